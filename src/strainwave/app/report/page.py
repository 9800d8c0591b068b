"""One HTML page in the style of the report, that loads nothing."""

from html import escape
from pathlib import Path

from ...base.archive import version

HERE = Path(__file__).parent
POLICY = "default-src 'none'; style-src 'unsafe-inline'; img-src data:"  # pages load nothing


def plain_page(title: str, body: str, style: str = "", foot: str = "") -> str:
    """Write an HTML page of a body in the style of the report, that needs nothing else."""
    begin, end = ("", foot) if foot else (f"<h1>{escape(title)}</h1>\n", f"strainwave {escape(version())}")
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f'<meta http-equiv="Content-Security-Policy" content="{POLICY}">\n'
        f"<title>{escape(title)}</title>\n<style>{(HERE / 'page.css').read_text('utf-8')}{style}</style>\n"
        f"</head>\n<body>\n<main>\n{begin}{body}<footer>{end}</footer>\n</main>\n</body>\n</html>\n"
    )
