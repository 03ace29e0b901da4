"""The width of a text in Max's default font, Arial at 12 points, and the size of the box around it.

The advance widths are those of Helvetica's public AFM file; Arial's are the same by design. A box's
margins are those of boxes in patchers that Max saved: `t b b b` is 42 pixels wide, `loadbang` 58.
"""

FONT_SIZE = 12.0
MARGIN = 9.5  # sum of the margins left and right of the text
FIRST_LINE = {"comment": 20.0, "other": 22.0}
LINE_PITCH = 13.5
MIN_BOX_WIDTH = 29.5

# Thousandths of the font size, for the characters 32 to 126.
ADVANCE = [
    278, 278, 355, 556, 556, 889, 667, 222, 333, 333, 389, 584, 278, 333, 278, 278, 556, 556, 556,
    556, 556, 556, 556, 556, 556, 556, 278, 278, 584, 584, 584, 556, 1015, 667, 667, 722, 722, 667,
    611, 778, 722, 278, 500, 667, 556, 833, 722, 778, 667, 778, 722, 667, 611, 722, 667, 944, 667,
    667, 611, 278, 278, 278, 469, 556, 222, 556, 556, 500, 556, 556, 278, 556, 556, 222, 222, 500,
    222, 833, 556, 556, 556, 556, 333, 500, 278, 556, 500, 722, 500, 500, 500, 334, 260, 334, 584]
BOLD_FACTOR = 1.09  # width of Arial Bold relative to Arial, averaged over English text


def width(text, size=FONT_SIZE, bold=False):
    """Width of one line of text in pixels; a character outside ASCII counts as 0.6 em."""
    total = sum(ADVANCE[ord(c) - 32] if 32 <= ord(c) < 127 else 600 for c in text)
    return total * size / 1000 * (BOLD_FACTOR if bold else 1)


def wrap(text, pixels, size=FONT_SIZE, bold=False):
    """The lines into which a box with this much room for text breaks it, at blanks only."""
    lines = []
    for paragraph in text.split("\n"):
        line = ""
        for word in paragraph.split(" "):
            longer = f"{line} {word}" if line else word
            if line and width(longer, size, bold) > pixels:
                lines.append(line)
                line = word
            else:
                line = longer
        lines.append(line)
    return lines


def box_height(lines, maxclass="newobj", size=FONT_SIZE):
    first = FIRST_LINE["comment" if maxclass == "comment" else "other"]
    scale = size / FONT_SIZE
    return round((first + LINE_PITCH * (lines - 1)) * scale, 1)


def box_size(text, maxclass="newobj", max_width=None, size=FONT_SIZE, bold=False):
    """Width and height of the box that holds this text, wrapped at max_width."""
    natural = max(width(part, size, bold) for part in text.split("\n")) + MARGIN
    box_width = max(natural, MIN_BOX_WIDTH)
    if max_width:
        box_width = min(box_width, max_width)
    lines = wrap(text, box_width - MARGIN + 0.5, size, bold)
    widest = max(width(line, size, bold) for line in lines) + MARGIN + 1
    return round(max(box_width, min(widest, natural + 1)), 1), box_height(len(lines), maxclass, size)
