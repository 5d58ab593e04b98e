"""In the browser: files that are dropped are there, a bench file is corrected and becomes a recording."""

import numpy as np
from browser import needs_browser, needs_playwright
from studio_page import open_page, served

pytestmark = [needs_browser, needs_playwright]

DROP = """async ([names, texts]) => {
  const data = new DataTransfer();
  names.forEach((name, i) => data.items.add(new File([Uint8Array.from(texts[i], (char) => char.charCodeAt(0))], name)));
  const target = document.querySelector('#studio');
  for (const kind of ['dragover', 'drop'])
    target.dispatchEvent(new DragEvent(kind, { bubbles: true, dataTransfer: data }));
}"""


def test_dropped_files_are_taken_and_a_bench_file_is_corrected_and_opened(folder, tmp_path_factory):
    t = np.arange(0.0, 4.0, 2e-3)
    x = 0.03 * np.sin(9.0 * t)
    f = 1500.0 * np.gradient(x, t) + 60.0 * np.sign(np.cos(9.0 * t)) - 150.0
    rows = "\n".join(f"{a:.4f};{1e3 * b:.5f};{c:.3f}".replace(".", ",") for a, b, c in zip(t, x, f, strict=True))
    bench = f"Zeit [s];Weg;Kraft [N]\n{rows}\n"
    other = (folder / "hidden_fit.mcap").read_bytes()
    with served(folder) as (_, url), open_page(url) as user:
        user.page.evaluate(DROP, [["run.csv", "evil.exe"], [bench, "x"]])
        user.until(lambda: "added run.csv" in user.text_of("upload-message"))
        assert "evil.exe: is no recording" in user.text_of("upload-message") and not (folder / "evil.exe").exists()
        user.until(user.page.locator("#bench").is_visible)
        assert "the unit of 'Weg' (displacement) is not named" in user.text_of("bench-form")
        user.page.locator(".bench .dash-dropdown").nth(1).click()
        user.page.locator(".dash-dropdown-content").get_by_text("damper displacement in mm", exact=True).click()
        user.until(lambda: user.page.locator(".bench-velocity .scatterlayer .trace").count())
        user.page.click("#bench-import")
        user.until(lambda: "imported as run.mcap" in user.text_of("bench-message"))
        (folder / "later.mcap").write_bytes(other)  # the lists notice it by themselves
        user.until(lambda: _offers(user, "later.mcap"))
        user.open(["run.mcap"], ["linear_viscous"])
        assert float(user.rms()) > 0.0
        with user.page.expect_file_chooser() as chooser:
            user.page.click("#chooser summary")
            user.page.click("#add-files")
        chooser.value.set_files(str(folder / "before.yaml"))
        user.until(lambda: "before.yaml: exists already" in user.text_of("upload-message"))
        assert len([text for text in user.faults if "409" not in text and "400" not in text]) == 0


def _offers(user, name: str) -> bool:
    user.page.click("#recordings")
    there = user.page.locator(".dash-dropdown-content").get_by_text(name, exact=True).count() > 0
    user.page.keyboard.press("Escape")
    return there
