"""The studio in hard use: by keyboard alone, in two pages at once, zoomed far, cancelled, and with its server gone."""

import re
import signal

import pytest
from browser import needs_browser, needs_playwright
from hand import Hand, hand, served

pytestmark = [needs_browser, needs_playwright]
SECONDS = 4.0


def reach(own: Hand, wanted: str, most: int = 60) -> None:
    """Presses Tab until the focus is on, or in, an element."""
    for _ in range(most):
        own.page.keyboard.press("Tab")
        if focused(own, wanted):
            return
    raise AssertionError(f"{wanted} is not reached with Tab")


def focused(own: Hand, wanted: str) -> bool:
    """Whether the focus is on, or in, an element."""
    return own.page.evaluate("wanted => !!document.activeElement.closest(wanted)", wanted)


def test_by_keyboard_alone(folder):
    with served(folder) as (_, url), hand(url) as own:
        keys = own.page.keyboard
        for dropdown, name in (("recordings", "hidden_fit"), ("models", "before")):
            reach(own, f"#{dropdown}")
            keys.press("Enter")
            own.until(lambda: focused(own, ".dash-dropdown-search"))
            keys.type(name)
            own.until(lambda: own.page.locator(".dash-dropdown-content [role=option]").count() == 1)
            reach(own, ".dash-options-list-option-checkbox")
            keys.press("Space")
            own.until(lambda dropdown=dropdown, name=name: name in own.text_of(dropdown))
            keys.press("Escape")
            own.until(lambda dropdown=dropdown: focused(own, f"#{dropdown}"))
        reach(own, "#stop")
        keys.type(str(SECONDS))
        reach(own, "#open")
        keys.press("Enter")
        own.done("opening")
        own.until(lambda: own.text_of("regions"))
        reach(own, "#tool")
        keys.press("ArrowRight")
        own.until(lambda: own.figure("time")["layout"]["dragmode"] == "pan")
        reach(own, ".region")
        keys.press("Enter")
        own.until(lambda: own.seen()[1] - own.seen()[0] == pytest.approx(2.0))
        assert not own.faults


def test_what_is_reported_twice_changes_nothing(folder):
    """Answers overlap on a slow machine; a list that is made anew takes the focus, and the next key, away."""
    with served(folder) as (_, url), hand(url) as own:
        own.open(["hidden_fit.mcap"], ["before.yaml"], stop=SECONDS)
        own.until(lambda: own.text_of("regions"))
        lists = [f"document.querySelector('{name} > *').kept" for name in ("#regions", "#parameters", "#steps")]
        own.page.evaluate(" = ".join([*lists, "true"]))
        with own.page.expect_request(lambda sent: '"id":"rebuilt"' in (sent.post_data or "")) as asked:
            own.page.wait_for_timeout(100)
        reported = re.findall(r'"id":"(generation|rebuilt)","property":"data","value":(\d+)', asked.value.post_data)
        assert len(reported) == 2
        for name, count in reported * 3:
            own.page.evaluate(f"dash_clientside.set_props('reported-{name}', {{ data: {count} }})")
        own.page.wait_for_load_state("networkidle")
        own.page.wait_for_timeout(1000)
        assert own.page.evaluate(" && ".join(lists))


def test_two_pages_do_not_disturb_each_other_and_a_cancelled_work_changes_nothing(folder):
    with served(folder) as (process, url), hand(url) as own:
        own.open(["hidden_fit.mcap"], ["before.yaml"], stop=SECONDS)
        before = own.rms()
        other = Hand(own.page.context.new_page(), url)
        other.open(["hidden_unseen.mcap"], ["linear_viscous"], stop=SECONDS)
        own.page.bring_to_front()
        own.tab("What is missing")
        own.page.click("#diagnose")
        own.until(lambda: own.page.locator("#progress").is_visible() and own.workers(process))
        other.page.bring_to_front()
        other.tab("Model")
        other.page.click("#refit")
        other.done("identifying")
        other.until(lambda: other.page.locator("#steps li").count() == 2)
        own.page.bring_to_front()
        own.page.click("#cancel")
        own.done("diagnosing", "cancelled")
        own.until(lambda: not own.workers(process) and own.page.locator("#progress").is_hidden())
        assert own.rms() == before and "Diagnose tries" in own.text_of("findings")
        assert not own.faults and not other.faults


def test_far_zooms_and_a_server_that_is_gone(folder):
    with served(folder) as (process, url), hand(url) as own:
        own.open(["hidden_fit.mcap"], ["before.yaml"], stop=SECONDS)
        own.until(lambda: own.text_of("regions"))
        for stretch in ([1.0, 1.0001], [-1e6, 1e6], [1e5, 2e5], [1.0, 3.0]):
            own.page.evaluate(
                "([start, stop]) => Plotly.relayout(document.querySelector('.figure.time .js-plotly-plot'),"
                " {'xaxis.range[0]': start, 'xaxis.range[1]': stop})",
                stretch,
            )
            own.page.wait_for_timeout(700)
            assert own.seen() == pytest.approx(stretch)
        assert not own.faults
        assert own.page.locator("#gone").is_hidden()
        process.send_signal(signal.SIGKILL)
        process.wait()
        own.until(own.page.locator("#gone").is_visible)
