"""The page in a real browser: it draws without a network, zooms, follows a region, switches damper and theme."""

import re
import subprocess

import numpy as np
from browser import BROWSER, PAGE_FLAGS, needs_browser

from damper_estimator.effects.discovery import find_effect
from damper_estimator.model import make_element
from damper_estimator.model.damper_model import DamperModel
from damper_estimator.report import comparison_page, damper_section
from damper_estimator.signals import Counts, Measurement, default_signals
from damper_estimator.signals.kinematics import Differentiator
from damper_estimator.validation import compare

# Walks through the page and leaves what it saw as the page's only content.
WALK = """<script>
const seen = []; const wait = () => new Promise((go) => setTimeout(go, 300));
window.addEventListener("error", (event) => seen.push("error " + event.message));
(async () => {
  await wait();
  const one = document.getElementById("damper0"), time = one.querySelector(".time");
  const range = () => time.layout.xaxis.range.map((v) => v.toFixed(1));
  seen.push("figures " + one.querySelectorAll(".figure .main-svg").length / 3);
  seen.push("opens on " + (time.layout.xaxis.range[1] - time.layout.xaxis.range[0]).toFixed(1) + " s");
  one.querySelector(".zoom[data-seconds=all]").click(); await wait();
  seen.push("all " + range());
  one.querySelector(".region").click(); await wait();
  const [first, last] = time.layout.xaxis.range;
  seen.push("region " + (last - first).toFixed(1) + " " + one.querySelector(".cloud").data[0].mode);
  Plotly.relayout(time, { "xaxis.range[0]": 3, "xaxis.range[1]": 4 }); await wait();
  const x = one.querySelector(".time").data[0].x;
  seen.push("zoom " + range() + " " + (x[0] >= 2.9 && x[x.length - 1] <= 4.1));
  Plotly.relayout(time, { "xaxis.autorange": true }); await wait();
  seen.push("back " + range());
  const map = one.querySelector(".map"), [motion, cycles] = one.querySelectorAll(".over");
  cycles.click(); await wait();
  seen.push("over " + map.textContent + " " + cycles.getAttribute("aria-pressed"));
  motion.click(); await wait();
  seen.push("map " + map.data[0].type + " " + motion.getAttribute("aria-pressed"));
  document.querySelectorAll(".tab")[1].click(); await wait();
  const other = document.getElementById("damper1");
  other.querySelectorAll(".over")[1].click(); await wait();
  seen.push("over " + other.querySelector(".map").layout.xaxis.type);
  seen.push("hidden " + one.hidden + " " + document.getElementById("damper1").querySelector(".time").data.length);
  let inside = true;
  for (const zoom of other.querySelectorAll(".zoom")) {
    zoom.click(); await wait();
    const [from, to] = other.querySelector(".time").layout.xaxis.range;
    inside = inside && from >= 0 && to <= 20;
  }
  seen.push("within the recording " + inside);
  const before = document.documentElement.className;
  document.getElementById("theme").click(); await wait();
  seen.push("theme " + (before !== document.documentElement.className));
  const result = document.createElement("pre"); result.id = "seen"; result.textContent = seen.join(";");
  document.body.replaceChildren(result);
})();
</script></body>"""


def comparison(name):
    """A sine on the left; on the right it becomes faster and smaller."""
    stamp = np.arange(20_000, dtype=np.int64) * 1_000_000
    time = stamp * 1e-9
    rate = 0.0 if name == "left" else 0.3
    x = 0.01 * np.sin(2 * np.pi * (1.7 + 0.5 * rate * time) * time) / (1.0 + rate * time)
    kinematics, verdict = Differentiator(60.0, 0.1).block(stamp, x)
    force = 1000.0 * kinematics.velocity + 300.0 * (kinematics.velocity > 0.05)
    model = DamperModel("viscous", "", (make_element(find_effect("linear_viscous")),))
    return compare(
        model,
        Measurement(
            "a.mcap",
            name,
            kinematics,
            force,
            kinematics.warm(),
            Counts.of(verdict),
            force,
            x,
            60.0,
            30.0,
            default_signals(name),
        ),
    )


@needs_browser
def test_the_page_can_be_walked_through(tmp_path):
    page = comparison_page([damper_section([comparison(name)], 2) for name in ("left", "right")], "title")
    (tmp_path / "page.html").write_text(page.replace("</body>", WALK))
    command = [BROWSER, *PAGE_FLAGS, f"--user-data-dir={tmp_path / 'profile'}", f"file://{tmp_path / 'page.html'}"]
    dom = subprocess.run(command, capture_output=True, text=True, timeout=120).stdout
    seen = re.search(r'<pre id="seen">(.*?)</pre>', dom)
    assert seen, "the walk did not end"
    assert seen.group(1).split(";") == [
        "figures 8",
        "opens on 1.0 s",
        "all 0.0,20.0",
        "region 2.0 lines",
        "zoom 3.0,4.0 true",
        "back 0.0,20.0",
        "over Frequency and amplitude hardly vary in these recordings. true",
        "map heatmap true",
        "over log",
        "hidden true 3",
        "within the recording true",
        "theme true",
    ]
