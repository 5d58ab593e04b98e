"""In the browser: work survives reloads, restarts, other recordings, other tabs and other sites."""

import http.server
import re
import signal
import threading

import pytest
from browser import needs_browser, needs_playwright
from hand import Hand, hand, served

pytestmark = [needs_browser, needs_playwright]
SECONDS = 4.0


def moved(own: Hand, value: float, field: int = 0) -> None:
    """Gives a parameter a value by hand, and waits until it is a step that is kept."""
    own.tab("Model")
    before = own.rms()
    number = own.page.locator("#parameters input.dash-input-element").nth(field)
    number.fill(str(value))
    number.press("Enter")
    own.until(lambda: own.rms() != before and "session=" in own.page.url)


def state(own: Hand) -> tuple:
    """What a user sees of a session."""
    own.tab("Steps")
    own.until(lambda: own.page.locator("#steps li").count())
    return own.rms(), own.page.locator("#steps li").count(), own.page.locator("#steps .now").inner_text()


def session_in(url: str) -> str:
    """The session's name in an address; "" while it has none."""
    return "".join(re.findall(r"session=([^&]*)", url))


def zoomed(own: Hand) -> None:
    own.drag(".figure.time .nsewdrag", (0.5, 0.3), (0.8, 0.3))
    own.until(lambda: own.seen()[1] - own.seen()[0] < 0.5 * SECONDS)
    own.until(lambda: "from=" in own.page.url)


def test_a_reload_a_restart_and_a_colleague_see_the_same(folder):
    with served(folder) as (process, url), hand(url) as own:
        own.open(["hidden_fit.mcap"], ["before.yaml", "linear_viscous"], ("hidden_unseen.mcap",), SECONDS)
        moved(own, -950)
        moved(own, -700, 1)
        own.page.click("#undo")
        own.until(lambda: "step=1" in own.page.url)
        zoomed(own)
        before, stretch = state(own), own.seen()
        own.until(lambda: "tab=steps" in own.page.url)
        link = own.page.url
        assert re.search(
            r"recording=hidden_fit.mcap&unseen=hidden_unseen.mcap&damper=passenger_front&.*model=before", link
        )
        own.page.reload()
        own.done("opening")
        assert state(own) == before
        own.until(lambda: own.seen() == pytest.approx(stretch, abs=1e-3))

        other = Hand(own.page.context.browser.new_context().new_page(), link)
        other.done("opening")
        assert state(other) == before
        other.until(lambda: other.seen() == pytest.approx(stretch, abs=1e-3))
        moved(other, -400, 2)
        other.until(lambda: session_in(other.page.url) not in ("", session_in(link)))
        other.page.close()
        assert state(own) == before

        port = re.search(r":(\d+)/", url).group(1)
        process.send_signal(signal.SIGKILL)
        process.wait()
        own.until(own.page.locator("#gone").is_visible)
        with served(folder, "--port", port):
            own.done("opening")  # the page goes on by itself
            own.until(lambda: own.rms() == before[0])
            assert state(own) == before and own.page.locator("#gone").is_hidden()
            own.page.click("#redo")
            own.until(lambda: own.rms() != before[0])


def test_other_recordings_leave_the_steps_a_click_away(folder):
    with served(folder) as (_, url), hand(url) as own:
        own.open(["hidden_fit.mcap"], ["before.yaml"], stop=SECONDS)
        moved(own, -950)
        before = state(own)
        own.page.click("#chooser summary")
        own.choose("recordings", "hidden_fit.mcap", "hidden_unseen.mcap")
        own.page.click("#open")
        own.until(lambda: own.page.locator("#steps li").count() == 1)
        assert "session=" not in own.page.url
        own.until(own.page.locator("#recordings").is_hidden)  # it folds itself once more
        own.page.click("#chooser summary >> nth=0")
        own.page.click("#earlier summary")
        assert "1 step" in own.text_of("earlier")
        own.page.locator("#earlier a").first.click()
        own.done("opening")
        own.until(lambda: own.rms() == before[0])
        assert state(own) == before and not own.faults


def test_undo_and_redo_work_wherever_the_focus_is(folder):
    with served(folder) as (_, url), hand(url) as own:
        own.open(["hidden_fit.mcap"], ["before.yaml"], stop=SECONDS)
        given = own.rms()
        moved(own, -950)
        own.until(lambda: own.rms() != given)
        changed = own.rms()
        zoomed(own)
        stretch = own.seen()
        number = own.page.locator("#parameters input.dash-input-element").first
        places = {
            "a tab": lambda: own.tab("Steps"),
            "a tool": lambda: own.page.locator("#tool").get_by_text("pan").click(),
            "a figure": lambda: own.page.locator(".figure.velocity").click(),
            "the page": lambda: own.page.locator("h1").click(),
            "a dropdown": lambda: own.page.locator("#chooser summary").first.focus(),
            "a number that was entered": lambda: (own.tab("Model"), number.focus()),
        }
        for i, (name, focus) in enumerate(places.items()):
            focus()
            own.page.keyboard.press("Control+z")
            own.until(lambda: own.rms() == given)
            own.until(own.page.locator("#redo").is_enabled)
            focus()
            own.page.keyboard.press(("Control+Shift+Z", "Control+y")[i % 2])
            own.until(lambda: own.rms() == changed)
            own.until(own.page.locator("#undo").is_enabled)
            assert own.seen() == pytest.approx(stretch), name
        own.tab("Save")
        own.page.fill("#name", "half.yaml")
        own.page.locator("#name").press("End")
        own.page.keyboard.type("x")
        own.page.keyboard.press("Control+z")  # of the text that is being typed
        own.page.wait_for_timeout(700)
        assert own.rms() == changed and own.page.input_value("#name") != "half.yamlx"
        own.page.click("#back")  # of the zoom, and of nothing else
        own.until(lambda: own.seen()[1] - own.seen()[0] > 0.9 * SECONDS)
        assert own.rms() == changed and not own.faults


def test_enter_saves_and_says_what_and_the_model_can_be_chosen_at_once(folder):
    with served(folder) as (_, url), hand(url) as own:
        own.open(["hidden_fit.mcap"], ["before.yaml"], stop=SECONDS)
        moved(own, -950)
        own.tab("Save")
        own.page.fill("#name", "mine.yaml")
        own.page.locator("#name").press("Enter")
        own.until(lambda: "saved mine.yaml: step 1" in own.text_of("save-message"))
        assert "N unseen" in own.text_of("save-message") and (folder / "mine.yaml").exists()
        own.page.locator("#name").press("Enter")
        own.until(lambda: "exists already" in own.text_of("save-message"))
        own.page.click("#chooser summary")
        own.choose("models", "mine.yaml")
        own.until(lambda: "mine.yaml" in own.text_of("models"))
        assert not own.faults


EVIL = """<!doctype html><title>evil</title><body><script>
const target = "TARGET";
for (let i = 0; i < 12; i++) {
  for (const path of ["", "_dash-layout", "_dash-dependencies"]) {
    fetch(target + path + "?" + i, { mode: "no-cors", credentials: "include" }).catch(() => 0);
    new Image().src = target + path + "?" + i;
    const frame = document.createElement("iframe"); frame.src = target + path; document.body.append(frame);
  }
  fetch(target + "_dash-update-component", { method: "POST", mode: "no-cors", body: "{}" }).catch(() => 0);
  const form = document.createElement("form"), sheet = document.createElement("iframe");
  sheet.name = "f" + i; form.target = sheet.name; form.method = "POST"; form.action = target + "leave";
  document.body.append(sheet, form); form.submit();
}
setTimeout(() => { document.title = "done"; }, 2000);
</script></body>"""


def test_another_site_in_the_same_browser_ends_nothing(folder):
    with served(folder) as (_, url), hand(url) as own:
        own.open(["hidden_fit.mcap"], ["before.yaml"], stop=SECONDS)
        page = EVIL.replace("TARGET", url).encode()

        class Evil(http.server.BaseHTTPRequestHandler):
            def do_GET(self):
                self.send_response(200)
                self.send_header("Content-Type", "text/html")
                self.end_headers()
                self.wfile.write(page)

            def log_message(self, *_):
                pass

        server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Evil)
        threading.Thread(target=server.serve_forever, daemon=True).start()
        other = own.page.context.new_page()
        answers = []
        other.on("response", lambda got: answers.append((got.url, got.status)))
        for host in ("127.0.0.1", "localhost"):  # the same site, and another one
            other.goto(f"http://{host}:{server.server_port}/")
            other.wait_for_function("document.title === 'done'", timeout=60_000)
        server.shutdown()
        reached = [status for asked, status in answers if asked.startswith(url)]
        assert len(reached) > 50 and set(reached) == {403}
        other.close()
        given = own.rms()
        moved(own, -950)  # the session is there
        own.page.click("#undo")
        own.until(lambda: own.rms() == given)


def test_a_link_on_another_site_leads_to_the_page(folder):
    with served(folder, "--token") as (_, url), hand(url) as own:
        own.open(["hidden_fit.mcap"], ["before.yaml"], stop=SECONDS)
        moved(own, -950)
        before, link = state(own), own.page.url
        own.page.goto("about:blank")
        own.page.set_content(f'<a href="{link}">look</a>')
        own.page.click("a")
        own.page.wait_for_selector("#recordings")
        own.done("opening")
        own.until(lambda: own.rms() == before[0])
