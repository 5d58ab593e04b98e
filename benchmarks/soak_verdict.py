"""What the soak found, in a table of the fault kinds and a list of violations."""

GROWTH = 0.05
FEWEST = 4  # looks at the memory of one process that tell of growth


def verdict(campaign) -> str:
    """Everything that was found; adds what memory tells to the violations."""
    judge = campaign.judge
    growth = [max(own[len(own) // 4 :]) / own[len(own) // 4] - 1.0 for own in campaign.memory if len(own) >= FEWEST]
    if growth and max(growth) > GROWTH:
        judge.violate(f"memory grew by {100 * max(growth):.1f} %", (), campaign.time)
    lines = [f"{'kind':36} rounds    GOOD  worst  excused  worst excused  violations"]
    for name, own in sorted(judge.tallies.items()):
        lines.append(
            f"{name:36} {own.rounds:6} {own.good:7} {own.worst:6.1f} {own.excused:8} "
            f"{own.worst_excused:14.1f} {own.violations:11}"
        )
    lines.append("GOOD: estimates marked so during the fault and a second after it; errors in force_stddev")
    lines += [f"excused {count} times: {reason}" for reason, count in judge.excuses.items()]
    lines.append(
        f"{campaign.time:.0f} s driven, {campaign.sent} displacement messages, {campaign.rounds.number} rounds, "
        f"{campaign.behind} leaps because this machine was too slow, {judge.unheard} answers lost"
    )
    if growth:
        lines.append(f"memory grew by {100 * max(growth):.1f} % at most in the life of a process")
    lines += [f"VIOLATION {what}" for what in judge.violations.values()]
    lines.append(
        f"{len(judge.violations)} sorts of violations; again with --seed {campaign.seed} (--first ROUND, --only KIND)"
    )
    return "\n".join(lines)
