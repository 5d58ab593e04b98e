"""The studio in hard use: by keyboard alone, in two pages at once, zoomed far, cancelled, and with its server gone."""

import re
import signal

import pytest
from browser import needs_browser, needs_playwright
from studio_page import StudioPage, open_page, served

pytestmark = [needs_browser, needs_playwright]
SECONDS = 4.0


def reach(user: StudioPage, wanted: str, most: int = 60) -> None:
    """Presses Tab until the focus is on, or in, an element."""
    for _ in range(most):
        user.page.keyboard.press("Tab")
        if focused(user, wanted):
            return
    raise AssertionError(f"{wanted} is not reached with Tab")


def focused(user: StudioPage, wanted: str) -> bool:
    """Whether the focus is on, or in, an element."""
    return user.page.evaluate("wanted => !!document.activeElement.closest(wanted)", wanted)


def test_by_keyboard_alone(folder):
    with served(folder) as (_, url), open_page(url) as user:
        keys = user.page.keyboard
        for dropdown, name in (("recordings", "hidden_fit"), ("models", "before")):
            reach(user, f"#{dropdown}")
            keys.press("Enter")
            user.until(lambda: focused(user, ".dash-dropdown-search"))
            keys.type(name)
            user.until(lambda: user.page.locator(".dash-dropdown-content [role=option]").count() == 1)
            # Part of the name may leave one option as well, and the keys that follow rebuild the list.
            user.until(lambda name=name: user.page.evaluate("document.activeElement.value") == name)
            reach(user, ".dash-options-list-option-checkbox")
            keys.press("Space")
            user.until(lambda dropdown=dropdown, name=name: name in user.text_of(dropdown))
            keys.press("Escape")
            user.until(lambda dropdown=dropdown: focused(user, f"#{dropdown}"))
        reach(user, "#stop")
        keys.type(str(SECONDS))
        reach(user, "#open")
        keys.press("Enter")
        user.done("opening")
        user.until(lambda: user.text_of("regions"))
        reach(user, "#tool")
        keys.press("ArrowRight")
        user.until(lambda: user.figure("time")["layout"]["dragmode"] == "pan")
        reach(user, ".region")
        keys.press("Enter")
        user.until(lambda: user.seen()[1] - user.seen()[0] == pytest.approx(2.0))
        assert not user.faults


def test_what_is_reported_twice_changes_nothing(folder):
    """Answers overlap on a slow machine; a list that is rebuilt takes the focus, and the next key, away."""
    with served(folder) as (_, url), open_page(url) as user:
        user.open(["hidden_fit.mcap"], ["before.yaml"], stop=SECONDS)
        places = [f"{name} > *" for name in ("#regions", "#parameters", "#steps")]
        user.until(lambda: all(user.page.locator(place).count() for place in places))
        lists = [f"document.querySelector('{place}').kept" for place in places]
        user.page.evaluate(" = ".join([*lists, "true"]))
        with user.page.expect_request(lambda sent: '"id":"rebuilt"' in (sent.post_data or "")) as asked:
            user.page.wait_for_timeout(100)
        reported = re.findall(r'"id":"(generation|rebuilt)","property":"data","value":(\d+)', asked.value.post_data)
        assert len(reported) == 2
        for name, count in reported * 3:
            user.page.evaluate(f"dash_clientside.set_props('reported-{name}', {{ data: {count} }})")
        user.page.wait_for_load_state("networkidle")
        user.page.wait_for_timeout(1000)
        assert user.page.evaluate(" && ".join(lists))


def test_two_pages_do_not_disturb_each_other_and_a_cancelled_work_changes_nothing(folder):
    with served(folder) as (process, url), open_page(url) as user:
        user.open(["hidden_fit.mcap"], ["before.yaml"], stop=SECONDS)
        before = user.rms()
        other = StudioPage(user.page.context.new_page(), url)
        other.open(["hidden_unseen.mcap"], ["linear_viscous"], stop=SECONDS)
        user.page.bring_to_front()
        user.tab("What is missing")
        user.page.click("#diagnose")
        user.until(lambda: user.page.locator("#progress").is_visible() and user.workers(process))
        other.page.bring_to_front()
        other.tab("Model")
        other.page.click("#refit")
        other.done("identifying")
        other.until(lambda: other.page.locator("#steps li").count() == 2)
        user.page.bring_to_front()
        user.page.click("#cancel")
        user.done("diagnosing", "cancelled")
        user.until(lambda: not user.workers(process) and user.page.locator("#progress").is_hidden())
        assert user.rms() == before and "Diagnose tries" in user.text_of("findings")
        assert not user.faults and not other.faults


def test_far_zooms_and_a_server_that_is_gone(folder):
    with served(folder) as (process, url), open_page(url) as user:
        user.open(["hidden_fit.mcap"], ["before.yaml"], stop=SECONDS)
        user.until(lambda: user.text_of("regions"))
        for stretch in ([1.0, 1.0001], [-1e6, 1e6], [1e5, 2e5], [1.0, 3.0]):
            user.page.evaluate(
                "([start, stop]) => Plotly.relayout(document.querySelector('.figure.time .js-plotly-plot'),"
                " {'xaxis.range[0]': start, 'xaxis.range[1]': stop})",
                stretch,
            )
            user.page.wait_for_timeout(700)
            assert user.seen() == pytest.approx(stretch)
        assert not user.faults
        assert user.page.locator("#gone").is_hidden()
        process.send_signal(signal.SIGKILL)
        process.wait()
        user.until(user.page.locator("#gone").is_visible)
