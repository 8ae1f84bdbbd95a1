"""Reads a figure that `phalanx report --figures` wrote as PDF: one page, its letters as text, its fonts inside.

    read_figure.py FILE.pdf

Prints the width and height of the page in inches, the fonts, the sizes of the letters in points, ascending, and all text; exit code 1 if
a font is not embedded.
"""

import sys

import pypdf


def main(path):
    reader = pypdf.PdfReader(path)
    (page,) = reader.pages
    names = []
    for font in page["/Resources"]["/Font"].values():
        (descendant,) = font["/DescendantFonts"]
        if not descendant.get_object()["/FontDescriptor"]["/FontFile2"].get_data():
            sys.exit(f"{path}: a font is not embedded")
        names.append(font["/BaseFont"])
    sizes = set()

    def visit(text, page_matrix, text_matrix, _, size):
        if text.strip():
            # The lengths of a unit upwards, of the page and of the text.
            scales = [(matrix[2] ** 2 + matrix[3] ** 2) ** 0.5 for matrix in (page_matrix, text_matrix)]
            sizes.add(f"{size * scales[0] * scales[1]:.2f}")

    text = page.extract_text(visitor_text=visit)
    print(f"{float(page.mediabox.width) / 72:.2f} x {float(page.mediabox.height) / 72:.2f} in")
    print("fonts:", *sorted(names))
    print("points:", *sorted(sizes, key=float))
    print(text)


main(sys.argv[1])
