"""Puts what commands print now into a page of documentation in place of what it says they print."""

import difflib
import re

from _console import BLOCK, agrees, execute, sessions, write_file

GAP = "..."
LIKENESS_THRESHOLD = 0.6  # of two lines, numbers aside: below it a line of the page has no counterpart in the output


def likeness(a, b):
    """How alike two lines are, from 0 to 1, whatever their numbers and spaces are."""
    words = [re.sub(r"\d[\d.e+-]*", "#", line).split() for line in (a, b)]
    return difflib.SequenceMatcher(None, " ".join(words[0]), " ".join(words[1])).ratio()


def counterparts(lines, printed):
    """For each line the index of the printed line that it is about, in order; None where there is none."""
    if not lines:
        return []
    alike = [[likeness(line, other) for other in printed] for line in lines]
    # best[i][j]: the most that lines[i:] can agree with printed[j:]
    best = [[0.0] * (len(printed) + 1) for _ in range(len(lines) + 1)]
    for i in reversed(range(len(lines))):
        for j in reversed(range(len(printed))):
            paired = alike[i][j] + best[i + 1][j + 1] if alike[i][j] >= LIKENESS_THRESHOLD else 0.0
            best[i][j] = max(paired, best[i + 1][j], best[i][j + 1])
    found, j = [], 0
    for i in range(len(lines)):
        while j < len(printed) and best[i][j] == best[i][j + 1] and best[i][j] > best[i + 1][j]:
            j += 1
        paired = j < len(printed) and best[i][j] > best[i + 1][j]
        found.append(j if paired else None)
        j += 1 if paired else 0
    return found


def refreshed_output(expected, printed):
    """The lines of a page, each replaced by the line that is printed now; `...` stays where lines are left out."""
    if agrees(expected, printed):
        return expected
    if GAP not in expected:
        return printed
    found = iter(counterparts([line for line in expected if line != GAP], printed))
    lines, begin, gap = [], 0, False
    for line in expected:
        index = len(printed) if line == GAP else next(found)
        if line == GAP or index is None:
            gap = True
            continue
        if index > begin:
            lines += [GAP] if gap else printed[begin:index]
        lines.append(printed[index])
        begin, gap = index + 1, False
    if begin < len(printed):
        lines += [GAP] if gap else printed[begin:]
    return lines


def refreshed_page(text, folder, environment):
    """(the page with the outputs of now, what ended with another exit code than 0)."""
    failed = []

    def refreshed_block(match):
        language, block = match.groups()
        write_file(block, folder)
        if language != "console":
            return match.group()
        lines = []
        for command, expected in sessions(block):
            code, printed, errors = execute(command, folder, environment)
            if code != 0:
                failed.append(f"$ {command}\nexit code {code}\n{errors}")
                printed = expected
            lines += [f"$ {command}", *refreshed_output(expected, printed)]
        return "```console\n" + "".join(f"{line}\n" for line in lines) + "```"

    return BLOCK.sub(refreshed_block, text), failed
