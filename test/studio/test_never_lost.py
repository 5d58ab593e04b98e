"""In the browser: work survives reloads, restarts, other recordings, other tabs and other sites."""

import http.server
import re
import signal
import threading

import pytest
from browser import needs_browser, needs_playwright
from studio_page import StudioPage, open_page, served

pytestmark = [needs_browser, needs_playwright]
SECONDS = 4.0


def moved(user: StudioPage, value: float, field: int = 0) -> None:
    """Gives a parameter a value by hand, and waits until it is a step that is kept."""
    user.tab("Model")
    before = user.rms()
    number = user.page.locator("#parameters input.dash-input-element").nth(field)
    number.fill(str(value))
    number.press("Enter")
    user.until(lambda: user.rms() != before and "session=" in user.page.url)


def state(user: StudioPage) -> tuple:
    """What a user sees of a session."""
    user.tab("Steps")
    user.until(lambda: user.page.locator("#steps li").count())
    return user.rms(), user.page.locator("#steps li").count(), user.page.locator("#steps .now").inner_text()


def session_in(url: str) -> str:
    """The session's name in an address; "" while it has none."""
    return "".join(re.findall(r"session=([^&]*)", url))


def zoomed(user: StudioPage) -> None:
    user.drag(".figure.time .nsewdrag", (0.5, 0.3), (0.8, 0.3))
    user.until(lambda: user.seen()[1] - user.seen()[0] < 0.5 * SECONDS)
    user.until(lambda: "from=" in user.page.url)


def test_a_reload_a_restart_and_a_colleague_see_the_same(folder):
    with served(folder) as (process, url), open_page(url) as user:
        user.open(["hidden_fit.mcap"], ["before.yaml", "linear_viscous"], ("hidden_unseen.mcap",), SECONDS)
        moved(user, -950)
        moved(user, -700, 1)
        user.page.click("#undo")
        user.until(lambda: "step=1" in user.page.url)
        zoomed(user)
        before, stretch = state(user), user.seen()
        user.until(lambda: "tab=steps" in user.page.url)
        link = user.page.url
        assert re.search(
            r"recording=hidden_fit.mcap&unseen=hidden_unseen.mcap&damper=passenger_front&.*model=before", link
        )
        user.page.reload()
        user.done("opening")
        user.until(lambda: state(user) == before)
        user.until(lambda: user.seen() == pytest.approx(stretch, abs=1e-3))

        other = StudioPage(user.page.context.browser.new_context().new_page(), link)
        other.done("opening")
        other.until(lambda: state(other) == before)
        other.until(lambda: other.seen() == pytest.approx(stretch, abs=1e-3))
        moved(other, -400, 2)
        other.until(lambda: session_in(other.page.url) not in ("", session_in(link)))
        other.page.close()
        user.until(lambda: state(user) == before)

        port = re.search(r":(\d+)/", url).group(1)
        process.send_signal(signal.SIGKILL)
        process.wait()
        user.until(user.page.locator("#gone").is_visible)
        with served(folder, "--port", port):
            user.until(user.page.locator("#gone").is_hidden)  # the page goes on by itself
            user.done("opening")
            user.until(lambda: user.rms() == before[0])
            user.until(lambda: state(user) == before)
            assert user.page.locator("#gone").is_hidden()
            user.page.click("#redo")
            user.until(lambda: user.rms() != before[0])


def test_other_recordings_leave_the_steps_a_click_away(folder):
    with served(folder) as (_, url), open_page(url) as user:
        user.open(["hidden_fit.mcap"], ["before.yaml"], stop=SECONDS)
        moved(user, -950)
        before = state(user)
        user.page.click("#chooser summary")
        user.choose("recordings", "hidden_fit.mcap", "hidden_unseen.mcap")
        user.page.click("#open")
        user.until(lambda: user.page.locator("#steps li").count() == 1)
        assert "session=" not in user.page.url
        user.until(user.page.locator("#recordings").is_hidden)  # it folds itself once more
        user.page.click("#chooser summary >> nth=0")
        user.page.click("#earlier summary")
        assert "1 step" in user.text_of("earlier")
        user.page.locator("#earlier a").first.click()
        user.done("opening")
        user.until(lambda: user.rms() == before[0])
        user.until(lambda: state(user) == before)
        assert not user.faults


def test_undo_and_redo_work_wherever_the_focus_is(folder):
    with served(folder) as (_, url), open_page(url) as user:
        user.open(["hidden_fit.mcap"], ["before.yaml"], stop=SECONDS)
        given = user.rms()
        moved(user, -950)
        user.until(lambda: user.rms() != given)
        changed = user.rms()
        user.until(user.page.locator("#undo").is_enabled)
        zoomed(user)
        stretch = user.seen()
        number = user.page.locator("#parameters input.dash-input-element").first
        places = {
            "a tab": lambda: user.tab("Steps"),
            "a tool": lambda: user.page.locator("#tool").get_by_text("pan").click(),
            "a figure": lambda: user.page.locator(".figure.velocity").click(),
            "the page": lambda: user.page.locator("h1").click(),
            "a dropdown": lambda: user.page.locator("#chooser summary").first.focus(),
            "a number that was entered": lambda: (user.tab("Model"), number.focus()),
        }
        for i, (name, focus) in enumerate(places.items()):
            focus()
            user.page.keyboard.press("Control+z")
            user.until(lambda: user.rms() == given)
            user.until(user.page.locator("#redo").is_enabled)
            focus()
            user.page.keyboard.press(("Control+Shift+Z", "Control+y")[i % 2])
            user.until(lambda: user.rms() == changed)
            user.until(user.page.locator("#undo").is_enabled)
            assert user.seen() == pytest.approx(stretch), name
        user.tab("Save")
        user.page.fill("#name", "half.yaml")
        user.page.locator("#name").press("End")
        user.page.keyboard.type("x")
        user.page.keyboard.press("Control+z")  # of the text that is being typed
        user.page.wait_for_timeout(700)
        assert user.rms() == changed and user.page.input_value("#name") != "half.yamlx"
        user.page.click("#back")  # of the zoom, and of nothing else
        user.until(lambda: user.seen()[1] - user.seen()[0] > 0.9 * SECONDS)
        assert user.rms() == changed and not user.faults


def test_enter_saves_and_says_what_and_the_model_can_be_chosen_at_once(folder):
    with served(folder) as (_, url), open_page(url) as user:
        user.open(["hidden_fit.mcap"], ["before.yaml"], stop=SECONDS)
        moved(user, -950)
        user.tab("Save")
        user.page.fill("#name", "mine.yaml")
        user.page.locator("#name").press("Enter")
        user.until(lambda: "saved mine.yaml: step 1" in user.text_of("save-message"))
        assert "N unseen" in user.text_of("save-message") and (folder / "mine.yaml").exists()
        user.page.locator("#name").press("Enter")
        user.until(lambda: "exists already" in user.text_of("save-message"))
        user.page.click("#chooser summary")
        user.choose("models", "mine.yaml")
        user.until(lambda: "mine.yaml" in user.text_of("models"))
        assert not user.faults


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
    with served(folder) as (_, url), open_page(url) as user:
        user.open(["hidden_fit.mcap"], ["before.yaml"], stop=SECONDS)
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
        other = user.page.context.new_page()
        answers = []
        other.on("response", lambda got: answers.append((got.url, got.status)))
        for host in ("127.0.0.1", "localhost"):  # the same site, and another one
            other.goto(f"http://{host}:{server.server_port}/")
            other.wait_for_function("document.title === 'done'", timeout=60_000)
        server.shutdown()
        reached = [status for asked, status in answers if asked.startswith(url)]
        assert len(reached) > 50 and set(reached) == {403}
        other.close()
        given = user.rms()
        moved(user, -950)  # the session is there
        user.page.click("#undo")
        user.until(lambda: user.rms() == given)


def test_a_link_on_another_site_leads_to_the_page(folder):
    with served(folder, "--token") as (_, url), open_page(url) as user:
        user.open(["hidden_fit.mcap"], ["before.yaml"], stop=SECONDS)
        moved(user, -950)
        before, link = state(user), user.page.url
        user.page.goto("about:blank")
        user.page.set_content(f'<a href="{link}">look</a>')
        user.page.click("a")
        user.page.wait_for_selector("#recordings")
        user.done("opening")
        user.until(lambda: user.rms() == before[0])
