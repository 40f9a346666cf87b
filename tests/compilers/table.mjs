// SPDX-License-Identifier: MIT
// The README's table of shader compilers, from what the stage saw in full.
//   node table.mjs take    build/compilers/results.json of OPENNTC_STAGES=compilers-all becomes results.json here and the table
//   node table.mjs check   fails when README.md does not have the table that results.json makes, or the plan has another row
import fs from 'node:fs'
import path from 'node:path'
import { plan as entries } from './plan.mjs'
import { begin, end, makeTable, summarise } from './summary.mjs'
import { here, root, work } from './tools.mjs'

const plan = entries.filter(entry => !entry.noRow)
const readme = path.join(root, 'README.md')
const kept = path.join(here, 'results.json')

const text = fs.readFileSync(readme, 'utf8')
const from = text.indexOf(begin), to = text.indexOf(end)
if (from < 0 || to < from) {
  console.error('README.md: the lines around the table of shader compilers are not there')
  process.exit(1)
}
if (process.argv[2] === 'take') {
  const seen = JSON.parse(fs.readFileSync(path.join(work, 'results.json'), 'utf8'))
  if (!seen.all) {
    console.error('build/compilers/results.json: not of a full run: OPENNTC_STAGES="release compilers-all" bash tests/run.sh')
    process.exit(1)
  }
  const summary = summarise(seen, plan)
  fs.writeFileSync(kept, JSON.stringify(summary, null, 1) + '\n')
  fs.writeFileSync(readme, text.slice(0, from) + makeTable(summary, plan) + text.slice(to + end.length))
} else {
  const summary = JSON.parse(fs.readFileSync(kept, 'utf8'))
  const planned = plan.map(entry => entry.id).join('\n'), known = summary.rows.map(row => row.id).join('\n')
  const problems = []
  if (planned !== known)
    problems.push('tests/compilers/results.json has other rows than plan.mjs')
  if (text.slice(from, to + end.length) !== makeTable(summary, plan))
    problems.push('README.md: its table of shader compilers is not what tests/compilers/results.json makes')
  for (const problem of problems)
    console.error(`${problem}: run OPENNTC_STAGES="release compilers-all", then node tests/compilers/table.mjs take`)
  process.exit(problems.length === 0 ? 0 : 1)
}
