"""The result of the soak: a table of the fault kinds and a list of violations."""

GROWTH = 0.05
FEWEST = 4  # memory readings of one process needed to detect growth


def verdict(campaign) -> str:
    """The complete result; adds memory growth to the violations."""
    judge = campaign.judge
    growth = [
        max(life[len(life) // 4 :]) / life[len(life) // 4] - 1.0 for life in campaign.memory if len(life) >= FEWEST
    ]
    if growth and max(growth) > GROWTH:
        judge.violate(f"memory grew by {100 * max(growth):.1f} %", (), campaign.time)
    lines = [f"{'kind':36} rounds    GOOD  worst  excused  worst excused  violations"]
    for name, tally in sorted(judge.tallies.items()):
        lines.append(
            f"{name:36} {tally.rounds:6} {tally.good:7} {tally.worst:6.1f} {tally.excused:8} "
            f"{tally.worst_excused:14.1f} {tally.violations:11}"
        )
    lines.append("GOOD: estimates marked so during the fault and a second after it; errors in force_stddev")
    lines += [f"excused {count} times: {reason}" for reason, count in judge.excuses.items()]
    lines.append(
        f"{campaign.time:.0f} s driven, {campaign.sent} displacement messages, {campaign.rounds.number} rounds, "
        f"{campaign.behind} leaps because this machine was too slow, {judge.unheard} answers lost"
    )
    if growth:
        lines.append(f"memory grew by at most {100 * max(growth):.1f} % in one process")
    lines += [f"VIOLATION {what}" for what in judge.violations.values()]
    lines.append(
        f"{len(judge.violations)} kinds of violations; repeat with --seed {campaign.seed} (--first ROUND, --only KIND)"
    )
    return "\n".join(lines)
