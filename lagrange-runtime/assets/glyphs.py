#!/usr/bin/env python3
"""The glyphs of a font as text, which the charts read: `python3 glyphs.py DejaVuSans.ttf > DejaVuSans.glyphs`.

Needs fontTools and uharfbuzz, and DejaVu Sans 2.37 (dejavu-fonts.github.io). A line is one of

    <code point> <advance> <outline>     outline as in SVG: M, L, Q and Z, absolute, y downwards, 2048 units to the em
    pair <advance> <two characters> …    kerning: added to the advance of the first
    mark <x> <y> <two characters> …      the second, a combining mark, is drawn there, seen from the end of the first

Code point 0 is drawn for characters that are missing.
"""

import io
import re
import sys
from collections import defaultdict

import uharfbuzz
from fontTools.pens.basePen import BasePen
from fontTools.subset import Options, Subsetter
from fontTools.ttLib import TTFont

CHARACTERS = (
    [range(0x20, 0x7F), range(0xA0, 0x100), range(0x300, 0x309), range(0x370, 0x400)]
    + [range(0x1D62, 0x1D6B), range(0x2010, 0x2016), range(0x2018, 0x201F), range(0x2070, 0x209D)]
    + [list(map(ord, "ıȷʰʱʲʳʴʵʶʷʸ†‡•…‰′″‴⁄ℂℏℓℕℝ\u212b←↑→↓↔↕⇒⇔∀∂∃∅∆∇∈∋∏∑−∓∕∖∗∘∙√∛∜∝∞∠∥∧∨∩∪∫≈≠≡≤≥≪≫⊕⊗⊥⋅"))]
)


class Outline(BasePen):
    def __init__(self, glyphs):
        super().__init__(glyphs)
        self.text = ""

    def add(self, letter, *points):
        self.text += letter + " ".join(f"{round(x)} {round(-y)}" for x, y in points)

    def _moveTo(self, point):
        self.add("M", point)

    def _lineTo(self, point):
        self.add("L", point)

    def _qCurveToOne(self, control, point):
        self.add("Q", control, point)

    def _closePath(self):
        self.text += "Z"


def main(path):
    # Letters with marks that are not wanted have to be gone before pairs are looked at, since they would be taken for them.
    font = TTFont(path)
    subset = Subsetter(Options(notdef_outline=True))
    subset.populate(unicodes={code for part in CHARACTERS for code in part})
    subset.subset(font)
    glyphs, names, order = font.getGlyphSet(), font.getBestCmap(), font.getGlyphOrder()
    file = io.BytesIO()
    font.save(file)
    shaper = uharfbuzz.Font(uharfbuzz.Face(file.getvalue()))

    def shaped(text):
        buffer = uharfbuzz.Buffer()
        buffer.add_str(text)
        buffer.guess_segment_properties()
        uharfbuzz.shape(shaper, buffer)
        infos = zip(buffer.glyph_infos, buffer.glyph_positions)
        return [(order[i.codepoint], p.x_advance, p.x_offset, p.y_offset) for i, p in infos]

    def box(name):
        glyph = font["glyf"][name]
        return glyph.xMin, glyph.yMin, glyph.xMax

    characters = sorted(names)
    for code in [0] + characters:
        name = names[code] if code else ".notdef"
        pen = Outline(glyphs)
        glyphs[name].draw(pen)
        # Contours of one point are anchors.
        outline = re.sub(r"M[-0-9 ]+Z", "", pen.text)
        print(f"{code:x} {glyphs[name].width} {outline}".rstrip())

    kerning, marks = defaultdict(list), defaultdict(list)
    for first in characters:
        for second in characters:
            pair, separate = chr(first) + chr(second), shaped(chr(first)) + shaped(chr(second))
            together = shaped(pair)
            if 0x300 <= second < 0x370:
                mark = names[second]
                left, bottom, right = box(mark)
                if len(together) == 2:
                    # Capital letters may have a flatter mark of their own: ours is put where its middle and foot are.
                    drawn, _, x, y = together[1]
                    x0, y0, x1 = box(drawn)
                    x, y = x + (x0 + x1 - left - right) / 2, y + y0 - bottom
                else:
                    parts = getattr(font["glyf"][together[0][0]], "components", [])
                    if len(parts) != 2:
                        continue
                    x0, y0, x1 = box(parts[1].glyphName)
                    x = parts[1].x + (x0 + x1 - left - right) / 2 - together[0][1]
                    y = parts[1].y + y0 - bottom
                marks[round(x), round(-y)].append(pair)
            elif together != separate and len(together) == 2 and not pair.isspace():
                kerning[together[0][1] - separate[0][1]].append(pair)
    for advance in sorted(kerning):
        print("pair", advance, *kerning[advance])
    for x, y in sorted(marks):
        print("mark", x, y, *marks[x, y])


main(sys.argv[1])
