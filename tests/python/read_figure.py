"""Reads a figure that `phalanx report --figures` wrote as PDF: one page, its letters as text, its font inside.

    read_figure.py FILE.pdf

Prints the width and height of the page in inches and all its text; exit code 1 if a font is not embedded.
"""

import sys

import pypdf


def main(path):
    reader = pypdf.PdfReader(path)
    (page,) = reader.pages
    for font in page["/Resources"]["/Font"].values():
        (descendant,) = font["/DescendantFonts"]
        if not descendant.get_object()["/FontDescriptor"]["/FontFile2"].get_data():
            sys.exit(f"{path}: a font is not embedded")
    print(f"{float(page.mediabox.width) / 72:.2f} x {float(page.mediabox.height) / 72:.2f} in")
    print(page.extract_text())


main(sys.argv[1])
