"""A picture of the top of a page, as a reader with a mouse sees it.

    python tools/docs/page_pictures.py PAGE.html PICTURE.png WIDTH HEIGHT [BUTTON]

BUTTON is pressed before, by its text.
Chromium's own --screenshot draws a page before its figures fit their elements, with their tools as on a touch screen.
"""

import shutil
import sys
from pathlib import Path

from playwright.sync_api import sync_playwright

BROWSER = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
REST = 1500  # ms, until the figures have come to rest


def main() -> None:
    """Takes the picture."""
    page, picture, width, height = Path(sys.argv[1]), Path(sys.argv[2]), *map(int, sys.argv[3:5])
    with sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=BROWSER, args=["--no-sandbox", "--disable-gpu"])
        shown = browser.new_page(viewport={"width": width, "height": height}, color_scheme="light")
        shown.goto(page.resolve().as_uri())
        shown.wait_for_selector(".js-plotly-plot .main-svg")
        for button in sys.argv[5:]:
            shown.get_by_role("button", name=button, exact=True).click()
            shown.mouse.move(0, 0)
        shown.wait_for_timeout(REST)
        shown.screenshot(path=picture)
        browser.close()
    print(f"wrote {picture}")


if __name__ == "__main__":
    main()
