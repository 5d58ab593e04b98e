"""The fleet's page in a real browser: it sorts, filters, and leads to the reports."""

import re
import subprocess

import pytest
from browser import BROWSER, PAGE_FLAGS, needs_browser
from test_fleet_page import TREND, row

from damper_estimator.report.fleet_page import fleet_page

# Walks through the page and leaves what it saw as the page's only content.
WALK = """<script>
const seen = []; const wait = () => new Promise((go) => setTimeout(go, 400));
window.addEventListener("error", (event) => seen.push("error " + event.message));
(async () => {
  await wait();
  const at = (id) => document.getElementById(id), first = () => document.querySelector("#rows tbody tr td").textContent;
  const set = (id, value) => { at(id).value = value; at(id).dispatchEvent(new Event("change")); };
  const tick = (id) => { at(id).checked = true; at(id).dispatchEvent(new Event("change")); };
  const record = (name) => seen.push(name + ": " + at("count").textContent + ", " + first());
  record("worst first");
  seen.push("points: " + at("time").data.map((trace) => trace.x.length));
  seen.push("link: " + document.querySelector("#rows tbody a").getAttribute("href"));
  document.querySelector("#rows thead button").click(); record("by name");
  document.querySelector("#rows thead button").click(); record("turned round");
  tick("far"); record("far"); at("reset").click();
  tick("failed"); record("failed");
  seen.push("reason: " + document.querySelector(".reason").textContent); at("reset").click();
  set("vehicle", "car 2"); record("vehicle"); at("reset").click();
  document.querySelector("#trends tbody tr").click(); record("drift"); at("reset").click();
  set("verb", "diagnose"); record("diagnose");
  seen.push("missing: " + at("missing").data[0].y + " " + at("missing").data[0].x.map(Math.round));
  const before = getComputedStyle(document.body).backgroundColor; at("theme").click();
  seen.push("theme " + (before !== getComputedStyle(document.body).backgroundColor));
  document.documentElement.innerHTML = "<pre>" + seen.join("\\n") + "</pre>";
})();
</script></body>"""


@pytest.fixture
def seen(tmp_path):
    rows = [row("car 1", number=k, error=0.05 + 0.001 * (k % 4)) for k in range(12)]
    rows += [row("car 2", number=k, error=0.06) for k in range(12, 22)] + [row("car 2", number=22, error=0.5)]
    rows.append(row("car 2", number=23, status="failed", reason="cut off", nrmse=None, rmse_n=None, report=None))
    found = [row(number=k, verdict="missing", missing=["friction", "inertia"][: 1 + k % 2]) for k in range(4)]
    page = fleet_page({"compare": rows, "diagnose": found}, [TREND], 2, "the rule")
    path = tmp_path / "index.html"
    path.write_text(page.replace("</body>", WALK))
    command = [BROWSER, *PAGE_FLAGS, f"--user-data-dir={tmp_path / 'home'}", path.as_uri()]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120)
    return re.search(r"<pre>(.*)</pre>", done.stdout, re.DOTALL).group(1).splitlines()


@needs_browser
def test_the_page_sorts_filters_and_links(seen):
    assert seen == [
        "worst first: 24 of 24 rows, 22",
        "points: 22,1",
        "link: tasks/22-ab/left.compare.html",
        "by name: 24 of 24 rows, 23",
        "turned round: 24 of 24 rows, 0",
        "far: 1 of 24 rows, 22",
        "failed: 1 of 24 rows, 23",
        "reason: cut off",
        "vehicle: 12 of 24 rows, 12",
        "drift: 12 of 24 rows, 0",
        "diagnose: 4 of 4 rows, 0",
        "missing: inertia,friction 50,100",
        "theme true",
    ]
