"""The pages of a diagnosis and an improvement in a real browser: every figure is drawn, in light and dark, for each
damper, and those that are folded away when they are opened.
"""

import re
import subprocess

from browser import BROWSER, PAGE_FLAGS, needs_browser

from damper_estimator.report import diagnosis_page, diagnosis_section, improvement_page, improvement_section

# Walks through the page and leaves what it saw as the page's only content.
WALK = """<script>
const seen = []; const wait = () => new Promise((go) => setTimeout(go, 300));
window.addEventListener("error", (event) => seen.push("error " + event.message));
(async () => {
  await wait();
  const shown = (part) => !part.closest("main[hidden], details:not([open])");
  const plots = () => [...document.querySelectorAll(".plot")].filter(shown);
  const drawn = (part) => part.querySelector(".main-svg") && part.offsetWidth > 200;
  const undrawn = () => plots().filter((part) => !drawn(part)).map((part) => part.dataset.name).join(" ");
  seen.push("undrawn [" + undrawn() + "]", "wide " + (document.documentElement.scrollWidth > innerWidth));
  const passage = document.querySelector("#damper0 [data-name=passage]");
  const points = passage._fullData[0].x.length, colour = passage.data[1].line.color;
  seen.push("points " + (points > 100), "colour " + /^#/.test(colour));
  document.getElementById("theme").click(); await wait();
  seen.push("theme " + (passage.data[1].line.color !== colour));
  const before = plots().length;
  for (const part of document.querySelectorAll("#damper0 details")) part.open = true;
  await wait();
  seen.push("unfolded " + (plots().length - before) + " [" + undrawn() + "]");
  document.querySelectorAll(".tab")[1].click(); await wait();
  seen.push("hidden " + document.getElementById("damper0").hidden + " [" + undrawn() + "]");
  const result = document.createElement("pre"); result.id = "seen"; result.textContent = seen.join(";");
  document.body.replaceChildren(result);
})();
</script></body>"""


def walked(page, folder):
    (folder / "page.html").write_text(page.replace("</body>", WALK))
    command = [BROWSER, *PAGE_FLAGS, f"--user-data-dir={folder / 'profile'}", f"file://{folder / 'page.html'}"]
    dom = subprocess.run(command, capture_output=True, text=True, timeout=120).stdout
    seen = re.search(r'<pre id="seen">(.*?)</pre>', dom)
    assert seen, "the walk did not end"
    return seen.group(1).split(";")


def expected(unfolded):
    return [
        "undrawn []", "wide false", "points true", "colour true", "theme true", f"unfolded {unfolded} []",
        "hidden true []",
    ]  # fmt: skip


@needs_browser
def test_a_diagnosis_can_be_walked_through(found, tmp_path):
    page = diagnosis_page([diagnosis_section(name, found) for name in ("left", "right")], "title")
    assert walked(page, tmp_path) == expected(0)


@needs_browser
def test_an_improvement_can_be_walked_through(improved, tmp_path):
    page = improvement_page([improvement_section(name, improved) for name in ("left", "right")], "title")
    first_curves = [curve for curve in improved.first.curves if curve.is_notable]
    assert first_curves and walked(page, tmp_path) == expected(2 + len(first_curves))
