"""Sections of the report, and the page and files that are made of them."""
import base64
import csv
import html
import io
import os
from dataclasses import dataclass, field

import matplotlib

matplotlib.use('Agg')
from matplotlib import pyplot  # noqa: E402


@dataclass
class Table:
    name: str        # of its CSV
    caption: str
    columns: list
    rows: list       # lists of text and numbers; None: not available
    command: str = ''


@dataclass
class Plot:
    name: str
    caption: str
    png: bytes
    command: str = ''


@dataclass
class Section:
    title: str
    text: list                                  # paragraphs
    tables: list = field(default_factory=list)
    plots: list = field(default_factory=list)


def cell(value):
    if value is None:
        return '-'
    if isinstance(value, bool):
        return 'yes' if value else 'no'
    if isinstance(value, float):
        if value != 0 and (abs(value) >= 1e5 or abs(value) < 1e-3):
            return f'{value:.2e}'.replace('e-0', 'e-').replace('e+0', 'e')
        return f'{value:.4g}'
    return str(value)


def draw(name, caption, paint, wide=1, tall=1, command=''):
    """A plot by paint(axes), `wide` of them beside each other in `tall` rows: one alone, or a flat list."""
    figure, axes = pyplot.subplots(tall, wide, figsize=((5.6 if wide < 3 else 4.2) * wide, (3.9 if tall < 2 else 3.4) * tall), squeeze=False)
    paint(list(axes.flat) if wide * tall > 1 else axes[0][0])
    for axis in axes.flat:
        axis.grid(True, alpha=.3)
    figure.tight_layout()
    buffer = io.BytesIO()
    figure.savefig(buffer, format='png', dpi=90)
    pyplot.close(figure)
    return Plot(name, caption, buffer.getvalue(), command)


def write_csv(folder, table):
    with open(os.path.join(folder, table.name + '.csv'), 'w', encoding='utf-8', newline='') as file:
        writer = csv.writer(file)
        writer.writerow(table.columns)
        writer.writerows([['' if v is None else v for v in row] for row in table.rows])


def markdown(table):
    lines = ['| ' + ' | '.join(table.columns) + ' |', '|' + '---|' * len(table.columns)]
    return lines + ['| ' + ' | '.join(cell(v) for v in row) + ' |' for row in table.rows]


STYLE = """body{font:16px/1.5 sans-serif;max-width:75em;margin:2em auto;padding:0 1em;color:#222}
table{border-collapse:collapse;margin:.5em 0;font-size:14px}td,th{border:1px solid #ccc;padding:.15em .6em;text-align:right}
th{background:#f3f3f3}td:first-child,th:first-child{text-align:left}caption,figcaption{text-align:left;color:#555}
code{background:#f3f3f3;padding:0 .2em}figure{margin:1em 0}img{max-width:100%}"""


def table_html(table):
    head = ''.join(f'<th>{html.escape(c)}</th>' for c in table.columns)
    body = ''.join('<tr>' + ''.join(f'<td>{html.escape(cell(v))}</td>' for v in row) + '</tr>\n' for row in table.rows)
    note = html.escape(table.caption) + (f'<br><code>{html.escape(table.command)}</code>' if table.command else '')
    return f'<table id="{table.name}"><caption>{note} (<code>{table.name}.csv</code>)</caption>\n<tr>{head}</tr>\n{body}</table>'


def plot_html(plot):
    image = base64.b64encode(plot.png).decode()
    note = html.escape(plot.caption) + (f'<br><code>{html.escape(plot.command)}</code>' if plot.command else '')
    return (
        f'<figure id="{plot.name}"><img alt="{html.escape(plot.caption)}"'
        f' src="data:image/png;base64,{image}"><figcaption>{note}</figcaption></figure>'
    )


def page(sections, facts):
    """The whole page, with nothing outside of it."""
    parts = [
        '<!DOCTYPE html><html lang="en"><head><meta charset="utf-8"><title>Unibody: speed against error</title>',
        f'<style>{STYLE}</style></head><body>', '<h1>Unibody: speed against error</h1>',
        '<table>' + ''.join(f'<tr><th>{html.escape(k)}</th><td>{html.escape(v)}</td></tr>' for k, v in facts) + '</table>',
        '<ul>' + ''.join(f'<li><a href="#s{n}">{html.escape(s.title)}</a></li>' for n, s in enumerate(sections)) + '</ul>']
    for n, section in enumerate(sections):
        parts.append(f'<h2 id="s{n}">{html.escape(section.title)}</h2>')
        parts += [f'<p>{html.escape(text)}</p>' for text in section.text]
        parts += [table_html(t) for t in section.tables] + [plot_html(p) for p in section.plots]
    return '\n'.join(parts) + '\n</body></html>\n'
