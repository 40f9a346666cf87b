// SPDX-License-Identifier: MIT
// The README's table of shader compilers, from what the stage saw in full.
//   node table.mjs take    build/compilers/results.json of OPENNTC_STAGES=compilers-all becomes results.json here and the table
//   node table.mjs check   fails when README.md does not have the table that results.json makes, or the plan has another row
import fs from 'node:fs'
import path from 'node:path'
import { plan as entries } from './plan.mjs'
import { here, maths, networks, root, work } from './tools.mjs'

const plan = entries.filter(entry => !entry.noRow)
const readme = path.join(root, 'README.md')
const kept = path.join(here, 'results.json')
const begin = '<!-- shader compilers: made by tests/compilers/table.mjs -->', end = '<!-- shader compilers: end -->'

/// A row for every entry of the plan: how many jobs came out as expected, of what; and whatever else came out.
function summarise({ date, versions, results }) {
  const rows = []
  for (const { id, expect } of plan) {
    const own = results.filter(result => result.id === id)
    if (own.length === 0)
      continue
    const list = key => [...new Set(own.map(result => result[key]))]
    const others = own.filter(result => !result.skipped && result.state !== expect)
    rows.push({
      id, expect, jobs: own.length, good: own.filter(result => result.state === expect).length,
      networks: list('network').filter(Boolean), maths: list('math').filter(Boolean), forms: list('form').filter(Boolean),
      numbers: own.reduce((sum, result) => sum + (result.compared ?? 0), 0), others: others.map(result => result.state).slice(0, 3),
      ...(own[0].skipped ? { skipped: own[0].skipped } : {}),
    })
  }
  return { date, versions, rows }
}

const range = (numbers, names) => numbers.length > 2 && numbers.length === Math.max(...numbers) - Math.min(...numbers) + 1
  ? `${names[Math.min(...numbers) - 1]} … ${names[Math.max(...numbers) - 1]}` : numbers.map(number => names[number - 1]).join(', ')
const formNames = { dot: '`NTC_DOT4_SM64`', spirvDot: '`NTC_DOT4_SPIRV`', wide: '`NTC_WIDE_WEIGHT_LOADS`', floats: '`NTC_FLOAT_DOT`' }

function makeTable({ date, versions, rows }) {
  const lines = [begin, '', '| compiler, into | networks; maths modes; forms | result |', '|---|---|---|']
  for (const row of rows) {
    const what = [range(row.networks, networks), range(row.maths, maths), row.forms.map(form => formNames[form]).join(', ')]
    const numbers = row.numbers > 0 ? `, ${row.numbers} numbers` : ''
    const result = row.skipped ? `not run: ${row.skipped}`
      : `**${row.expect}**, ${row.good} of ${row.jobs}${numbers}` + (row.others.length > 0 ? `; else: ${row.others.join('; ')}` : '')
    lines.push(`| ${row.id} | ${what.filter(Boolean).join('; ')} | ${result} |`)
  }
  const named = Object.entries(versions).filter(([, version]) => version).map(([name, version]) => `${name} ${version.replace(/^Glslang Version: /, '')}`)
  lines.push('', `*\`OPENNTC_STAGES="release compilers-all" bash tests/run.sh\` on ${date}: ${named.join(', ')}.*`, '', end)
  return lines.join('\n')
}

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
  const summary = summarise(seen)
  fs.writeFileSync(kept, JSON.stringify(summary, null, 1) + '\n')
  fs.writeFileSync(readme, text.slice(0, from) + makeTable(summary) + text.slice(to + end.length))
} else {
  const summary = JSON.parse(fs.readFileSync(kept, 'utf8'))
  const planned = plan.map(entry => entry.id).join('\n'), known = summary.rows.map(row => row.id).join('\n')
  const problems = []
  if (planned !== known)
    problems.push('tests/compilers/results.json has other rows than plan.mjs')
  if (text.slice(from, to + end.length) !== makeTable(summary))
    problems.push('README.md: its table of shader compilers is not what tests/compilers/results.json makes')
  for (const problem of problems)
    console.error(`${problem}: run OPENNTC_STAGES="release compilers-all", then node tests/compilers/table.mjs take`)
  process.exit(problems.length === 0 ? 0 : 1)
}
