"""docs/measurements.md: plots and tables of the report, written between two markers."""
import os
from dataclasses import replace

from page import markdown
from runs import COMMON, ROOT

BEGIN, END = '<!-- scripts/report --measurements writes from here -->', '<!-- to here -->'
PLOTS, TABLES = ('work_precision', 'rivals_boxes', 'velocity_level'), ('settings', 'defaults', 'one_setting', 'rivals_best')
LEFT_OUT = {'defaults': ('its ms / these', 'least error in no more time', 'its error / this')}  # columns, on the page only
PICTURES = os.path.join('scenes', 'pictures')


def without(table, columns):
    kept = [n for n, column in enumerate(table.columns) if column not in columns]
    return replace(table, columns=[table.columns[n] for n in kept], rows=[[row[n] for n in kept] for row in table.rows])


def result_lines(sections, facts, size):
    facts = dict(facts)
    missing = []
    option = '' if size == 'full' else f' --{size}'
    lines = [
        f'Made by `scripts/report{option} --measurements` on {facts["made"]}: {facts["machine"]}, {facts["compiler"]}; cores busy at'
        f' the start {facts["cores busy at the start"]}. All runs of unibody have {" and ".join(COMMON[:2])} beside what a row says, but for'
        ' those "as shipped": every setting then does all of its iterations, as other programs do theirs.'
    ]
    for kind, names in (('plots', PLOTS), ('tables', TABLES)):
        for name in names:
            item = next((i for s in sections for i in getattr(s, kind) if i.name == name), None)
            if item is None:
                missing.append(name)
                continue
            lines += ['', f'{item.caption} (`{item.command}`):' if item.command else f'{item.caption}:', '']
            if kind == 'tables':
                lines += markdown(without(item, LEFT_OUT.get(name, ())))
            else:
                lines.append(f'![{item.caption.split(".")[0]}](../{PICTURES}/report_{name}.png)')
    return lines + (['', f'Not made in this run: {", ".join(missing)}.'] if missing else [])


def write(sections, facts, size, root=ROOT):
    """Rewrites what stands between the markers, and the plots it shows."""
    path = os.path.join(root, 'docs', 'measurements.md')
    with open(path, encoding='utf-8') as file:
        text = file.read()
    if text.count(BEGIN) != 1 or text.count(END) != 1:
        raise SystemExit(f'report: docs/measurements.md needs the markers "{BEGIN}" and "{END}", once each')
    before, after = text.split(BEGIN)[0], text.split(END)[1]
    for section in sections:
        for plot in section.plots:
            if plot.name in PLOTS:
                with open(os.path.join(root, PICTURES, f'report_{plot.name}.png'), 'wb') as file:
                    file.write(plot.png)
    with open(path, 'w', encoding='utf-8') as file:
        file.write(before + BEGIN + '\n' + '\n'.join(result_lines(sections, facts, size)) + '\n' + END + after)
