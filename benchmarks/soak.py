"""Soak: the node in a closed loop with simulated dampers and random faults, for half an hour; an independent judge.

`make soak`, or with SECONDS and RATE on the command line; a short one is among the tests. Four semi-active dampers on
rough roads (`soak_plant`), models identified by the project's ``fit`` on recordings of them (`soak_model`), the node as
it is installed, over DDS. Every round has one fault or two at a time (`soak_faults`, `soak_node_faults`). The judge
(`soak_judge`, `soak_rule`, `soak_truth`) knows the truth and what was sent. Status 1 where it found something:

    a force marked GOOD that is off by more than three standard deviations, or must not be GOOD
    no GOOD, or a loop that does not follow, a second after the cause is gone
    a command outside the limits, or other than the safe current where that is due, as after every orderly end
    a counter of /diagnostics that is wrong, memory that grows by more than 5 %, a force that is no number

The same faults come again with the seed, the round of the violation and the same kinds: `--seed`, `--first`, `--only`.
"""

import argparse
import os
import sys
import tempfile
from pathlib import Path

MODELS = Path(__file__).resolve().parents[1] / "out" / "soak"


def arguments_of(words: list[str]) -> argparse.Namespace:
    """What is on the command line."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("seconds", type=float, nargs="?", default=1800.0)
    parser.add_argument("rate", type=float, nargs="?", default=500.0, help="Hz of the displacement")
    parser.add_argument("--seed", type=int, default=None, help="of faults, roads and noise (default: drawn)")
    parser.add_argument("--only", metavar="KIND", action="append", default=[], help="these kinds; all that begin so")
    parser.add_argument("--first", type=int, default=0, metavar="ROUND", help="begin with this round")
    parser.add_argument("--list", action="store_true", help="print the kinds")
    parser.add_argument("--without", action="store_true", help="no faults at all: the base rate")
    return parser.parse_args(words)


def main(words: list[str] | None = None) -> int:
    """The exit status is 1 where something was wrong."""
    arguments = arguments_of(sys.argv[1:] if words is None else words)
    import soak_node_faults  # noqa: F401
    import soak_slow_faults  # noqa: F401
    from soak_faults import KINDS

    if arguments.list:
        print("\n".join(f"{name}{'' if kind.is_possible else ' (not yet)'}" for name, kind in KINDS.items()))
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
