"""Soak: the node in a closed loop with simulated dampers and random faults, for half an hour, with an independent
judge.

`make soak`, or SECONDS and RATE on the command line; the tests include a short run. Four semi-active dampers on
rough roads (`soak_plant`), models identified by ``fit`` on their recordings (`soak_model`), and the installed node over
DDS. Every round has one fault or two at a time (`soak_faults`, `soak_node_faults`). The judge (`soak_judge`,
`soak_rule`, `soak_truth`) knows the truth and what was sent. Status 1 if it found a violation:

    a force marked GOOD with an error above three standard deviations, or that must not be GOOD
    no GOOD, or a loop that does not follow, a second after the end of the cause
    a command outside the limits, or different from the safe current when that is due, as after every orderly end
    a wrong counter of /diagnostics, memory growth above 5 %, a non-finite force

The seed, the round of the violation and the same kinds reproduce the same faults: `--seed`, `--first`, `--only`.
"""

import argparse
import os
import sys
import tempfile
from pathlib import Path

MODELS = Path(__file__).resolve().parents[1] / "out" / "soak"


def arguments_of(words: list[str]) -> argparse.Namespace:
    """The parsed command line."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("seconds", type=float, nargs="?", default=1800.0)
    parser.add_argument("rate", type=float, nargs="?", default=500.0, help="Hz of the displacement")
    parser.add_argument("--seed", type=int, default=None, help="of faults, roads and noise (default: drawn)")
    parser.add_argument("--only", metavar="KIND", action="append", default=[], help="only kinds that begin with this")
    parser.add_argument("--first", type=int, default=0, metavar="ROUND", help="begin with this round")
    parser.add_argument("--list", action="store_true", help="print the kinds and exit")
    parser.add_argument("--without", action="store_true", help="no faults: the base rate")
    return parser.parse_args(words)


def main(words: list[str] | None = None) -> int:
    """The exit status; 1 with violations."""
    arguments = arguments_of(sys.argv[1:] if words is None else words)
    import soak_node_faults  # noqa: F401
    import soak_slow_faults  # noqa: F401
    from soak_faults import KINDS

    if arguments.list:
        print("\n".join(f"{name}{'' if kind.is_possible else ' (not available)'}" for name, kind in KINDS.items()))
        return 0
    seed = arguments.seed if arguments.seed is not None else int.from_bytes(os.urandom(4), "little")
    kinds = [
        k for n, k in KINDS.items() if k.is_possible and (not arguments.only or n.startswith(tuple(arguments.only)))
    ]
    from soak_campaign import Campaign
    from soak_model import models
    from soak_verdict import verdict

    from damper_estimator.node.playback.domain import free_ros_domain

    with free_ros_domain(), tempfile.TemporaryDirectory() as folder:
        chosen = [] if arguments.without else kinds
        campaign = Campaign(Path(folder), models(MODELS), arguments.rate, seed, chosen, arguments.first)
        try:
            campaign.run(arguments.seconds)
        except RuntimeError as error:
            campaign.judge.violate(f"the campaign ended early: {error}", (), campaign.time)
        finally:
            campaign.close()
        print(verdict(campaign))
    return 1 if campaign.judge.violations else 0


if __name__ == "__main__":
    sys.exit(main())
