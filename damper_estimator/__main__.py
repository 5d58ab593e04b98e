"""``python -m damper_estimator`` is ``damper-estimator``."""

import sys

from damper_estimator.cli.main import main

sys.exit(main())
