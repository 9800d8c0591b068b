"""XML in few words: elements, and the text of a file."""

from xml.etree import ElementTree as Xml

Element = Xml.Element


def element(tag: str, attributes: dict[str, str]) -> Element:
    """Element with attributes, the empty ones left out."""
    return Element(tag, {name: value for name, value in attributes.items() if value})


def child(parent: Element, tag: str, text: str = "", **attributes: str) -> Element:
    """Last element inside another one, with attributes, the empty ones left out, or with a text."""
    made = element(tag, attributes)
    made.text = text or None
    parent.append(made)
    return made


def written(root: Element, comment: str = "") -> str:
    """Text of a file, with a comment at its top."""
    Xml.indent(root)
    head = "<!--\n" + comment.replace("--", "- -") + "\n-->\n" if comment else ""
    return f'<?xml version="1.0" encoding="UTF-8"?>\n{head}{Xml.tostring(root, encoding="unicode")}\n'
