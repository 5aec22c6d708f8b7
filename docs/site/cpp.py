"""The C++ reference from Doxygen's XML: for each header its opening comment and what it declares, as directives of Sphinx."""
import pathlib
import re
import xml.etree.ElementTree as ElementTree

MARKUP = re.compile(r"([\\*`|_])")


def text_of(node):
    """The node's text without its elements' markup."""
    return "".join(node.itertext()) if node is not None else ""


def lines_of_verbatim(text):
    """A formula or an example: Doxygen keeps the comment's slashes."""
    lines = [re.sub(r"^\s*///? ?", "", line).rstrip() for line in text.split("\n")]
    while lines and not lines[0].strip():
        lines.pop(0)
    while lines and not lines[-1].strip():
        lines.pop()
    return lines


def inline(node):
    """A paragraph's words; code stays code, everything else is no markup."""
    parts = [MARKUP.sub(r"\\\1", node.text or "")]
    for child in node:
        if child.tag == "computeroutput" and text_of(child).strip() == text_of(child) != "":
            parts.append("``" + text_of(child) + "``\\ ")
        else:
            parts.append(MARKUP.sub(r"\\\1", text_of(child)))
        parts.append(MARKUP.sub(r"\\\1", child.tail or ""))
    return " ".join("".join(parts).split())


def description(node):
    """A comment as blocks of lines."""
    blocks = []
    for part in ("briefdescription", "detaileddescription", "inbodydescription"):
        for para in node.findall(f"{part}/para"):
            copy = ElementTree.Element("para")
            copy.text = para.text
            for child in para:
                if child.tag in ("verbatim", "programlisting", "preformatted"):
                    blocks.append(inline(copy))
                    blocks.append(["::", ""] + ["   " + line for line in lines_of_verbatim(text_of(child))])
                    copy = ElementTree.Element("para")
                    copy.text = child.tail
                else:
                    copy.append(child)
            blocks.append(inline(copy))
    return [block for block in blocks if block]


def write(lines, blocks, depth):
    pad = "   " * depth
    for block in blocks:
        lines.append("")
        lines.extend((pad + line).rstrip() for line in ([block] if isinstance(block, str) else block))


def template_of(node):
    """template <...>, or nothing."""
    parameters = node.find("templateparamlist")
    if parameters is None:
        return ""
    written = []
    for parameter in parameters.findall("param"):
        one = text_of(parameter.find("type"))
        if parameter.find("declname") is not None and not one.endswith(" " + text_of(parameter.find("declname"))):
            one += " " + text_of(parameter.find("declname"))
        if parameter.find("defval") is not None:
            one += " = " + text_of(parameter.find("defval"))
        written.append(one)
    return "template<" + ", ".join(written) + "> "


def location(node):
    place = node.find("location")
    return place.get("file", "") if place is not None else ""


class Reference:
    """All of Doxygen's XML: declarations by header."""

    def __init__(self, folder):
        self.compounds, self.members, self.files, nested = {}, {}, {}, set()
        for path in sorted(pathlib.Path(folder).glob("*.xml")):
            if path.name in ("index.xml", "Doxyfile.xml"):
                continue
            for compound in ElementTree.parse(path).getroot().findall("compounddef"):
                kind = compound.get("kind")
                if kind in ("class", "struct", "union"):
                    self.compounds[compound.get("id")] = compound
                    nested.update(inner.get("refid") for inner in compound.findall("innerclass"))
                elif kind == "namespace":
                    for member in compound.findall("sectiondef/memberdef"):
                        self.members.setdefault(location(member), []).append((text_of(compound.find("compoundname")), member))
                elif kind == "file":
                    self.files[location(compound)] = compound
        self.types = {}
        for identity, compound in self.compounds.items():
            if identity not in nested and "<" not in text_of(compound.find("compoundname")):
                self.types.setdefault(location(compound), []).append(compound)

    def member(self, lines, node, depth):
        """A function, variable, alias or enum."""
        kind, name = node.get("kind"), text_of(node.find("name"))
        type_name, arguments = text_of(node.find("type")), text_of(node.find("argsstring"))
        type_name = re.sub(r"\b(friend|inline) ", "", type_name)
        if name.startswith("@") or node.get("prot") == "private" or kind in ("friend", "define"):
            return
        pad = "   " * depth
        if kind == "function":
            prefix = ("explicit " if node.get("explicit") == "yes" else "") + ("static " if node.get("static") == "yes" and depth else "") + (
                "virtual " if node.get("virt") != "non-virtual" and "override" not in arguments else "")
            arguments = re.sub(r"=\s*(default|delete|0)$", r" = \1", arguments)
            declaration = f"cpp:function:: {template_of(node)}{prefix}{type_name} {name}{arguments}"
        elif kind == "variable":
            value = text_of(node.find("initializer"))
            shown = " " + value if value and len(value) < 60 and "\n" not in value and "{" not in value[1:] else ""
            static = "static " if node.get("static") == "yes" and depth else ""
            declaration = f"cpp:{'member' if depth else 'var'}:: {static}{type_name} {name}{arguments}{shown}"
        elif kind == "typedef":
            value = type_name + arguments
            declaration = f"cpp:type:: {template_of(node)}{name} = {value}"
        elif kind == "enum":
            scoped = "enum-class" if node.get("strong") == "yes" else "enum"
            declaration = f"cpp:{scoped}:: {name}"
        else:
            return
        lines.append("")
        lines.append(pad + ".. " + " ".join(declaration.split()))
        write(lines, description(node), depth + 1)
        for value in node.findall("enumvalue"):
            lines.append("")
            lines.append(pad + f"   .. cpp:enumerator:: {text_of(value.find('name'))}")
            write(lines, description(value), depth + 2)

    def type(self, lines, compound, depth, name=None):
        """A class with its public and protected members."""
        name = name or text_of(compound.find("compoundname")).split("::")[-1]
        kind = "class" if compound.get("kind") == "class" else compound.get("kind")
        bases = [text_of(base) for base in compound.findall("basecompoundref") if base.get("prot") == "public"]
        declaration = f"cpp:{kind}:: {template_of(compound)}{name}" + (" : " + ", ".join(f"public {base}" for base in bases) if bases else "")
        pad = "   " * depth
        lines.append("")
        lines.append(pad + ".. " + " ".join(declaration.split()))
        write(lines, description(compound), depth + 1)
        for inner in compound.findall("innerclass"):
            if inner.get("prot") != "private" and inner.get("refid") in self.compounds:
                self.type(lines, self.compounds[inner.get("refid")], depth + 1)
        members = [m for section in compound.findall("sectiondef") if not section.get("kind").startswith("private") for m in section.findall("memberdef")]
        for member in sorted(members, key=lambda m: int(m.find("location").get("line", 0))):
            self.member(lines, member, depth + 1)

    def page(self, header):
        """The text of a header's page below its title."""
        lines = [f'``#include "procam/{header}"``']
        file = f"procam/{header}"
        if file in self.files:
            write(lines, description(self.files[file]), 0)
        entries = [(int(c.find("location").get("line", 0)), "::".join(text_of(c.find("compoundname")).split("::")[:-1]), c, True)
                   for c in self.types.get(file, [])]
        entries += [(int(m.find("location").get("line", 0)), namespace, m, False) for namespace, m in self.members.get(file, [])]
        current = None
        for _, namespace, node, is_type in sorted(entries, key=lambda entry: entry[0]):
            if namespace != current:
                lines += ["", f".. cpp:namespace:: {namespace}"]
                current = namespace
            if is_type:
                self.type(lines, node, 0)
            else:
                self.member(lines, node, 0)
        return "\n".join(lines) + "\n"
