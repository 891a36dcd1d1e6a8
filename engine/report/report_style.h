#pragma once

#include <string_view>

namespace palpate {

// Of the report: light, for wide and narrow screens and for paper.
inline constexpr std::string_view kReportStyle = R"css(
:root { color-scheme: light; --ink: #1d2329; --quiet: #57606a; --line: #d8dee4; --tint: #f6f8fa;
  --good: #00664b; --bad: #9c3f00; }
* { box-sizing: border-box; }
html { -webkit-text-size-adjust: 100%; text-size-adjust: 100%; }
body { margin: 0 auto; padding: 1.5rem 1.25rem 4rem; max-width: 1180px; color: var(--ink);
  background: #fff; font: 16px/1.5 system-ui, "Segoe UI", Roboto, "DejaVu Sans", sans-serif;
  overflow-wrap: anywhere; }
h1 { font-size: 1.9rem; line-height: 1.2; margin: 0 0 .5rem; }
h2 { font-size: 1.4rem; line-height: 1.25; margin: 3rem 0 .6rem; padding-top: 1.2rem;
  border-top: 2px solid var(--line); }
h3 { font-size: 1.05rem; margin: 1.4rem 0 .4rem; }
p { margin: .5rem 0; max-width: 75ch; }
a { color: #0057a3; }
code { font-family: ui-monospace, "DejaVu Sans Mono", monospace; font-size: .92em; }
dl.facts { display: grid; grid-template-columns: max-content 1fr; gap: .15rem 1rem; margin: 1rem 0;
  padding: .8rem 1rem; background: var(--tint); border: 1px solid var(--line); border-radius: 6px; }
dl.facts dt { color: var(--quiet); }
dl.facts dd { margin: 0; }
.wide { overflow-x: auto; margin: .6rem 0; }
table { border-collapse: collapse; font-size: .9rem; font-variant-numeric: tabular-nums;
  overflow-wrap: normal; }
th, td { padding: .3rem .6rem; border-bottom: 1px solid var(--line); text-align: left;
  vertical-align: top; }
thead th { border-bottom: 2px solid #8c959f; vertical-align: bottom; }
td.number, th.number { text-align: right; }
td.number { white-space: nowrap; }
th.number span { display: inline-block; max-width: 15em; }
td.verdict { min-width: 6.2em; }
td.verdict:nth-child(3) { min-width: 8em; }
.advice { margin: 1rem 0 2rem; padding: .2rem 1.2rem 1rem; border: 2px solid #0057a3;
  border-radius: 8px; background: var(--tint); }
.advice h2 { margin: .8rem 0 .2rem; padding: 0; border: 0; }
.advice dl { display: grid; grid-template-columns: max-content 1fr; gap: .6rem 1.2rem;
  margin: .8rem 0; }
.advice dt { font-weight: 600; }
.advice dd { margin: 0; }
.advice dd strong, .advice dd span { display: block; }
.advice .limit { color: var(--quiet); }
.advice pre { margin: .4rem 0 0; padding: .6rem .8rem; border: 1px solid var(--line);
  border-radius: 6px; background: #fff; white-space: pre-wrap; }
.advice pre span { display: inline-block; max-width: 100%; }
td .spread { color: var(--quiet); }
td.order { min-width: 12em; }
tr.method th { background: var(--tint); font-weight: 600; }
tr.chosen td { background: #fff6dd; }
.good { color: var(--good); }
.bad { color: var(--bad); }
.mark { display: inline-block; padding: 0 .4em; margin: 0 .2em .1em 0; border-radius: .6em;
  border: 1px solid currentColor; font-size: .82em; white-space: nowrap; }
.mark.front { color: #57606a; }
.mark.best { color: #1d2329; font-weight: 600; }
.mark.default { color: #0057a3; }
.mark.floor { color: #7a4f00; }
figure { margin: 1rem 0; }
.panels { display: grid; grid-template-columns: repeat(2, minmax(0, 1fr)); gap: .75rem; }
.panels svg { display: block; width: 100%; height: auto; }
figcaption, .note { color: var(--quiet); font-size: .9rem; max-width: 90ch; }
@media (max-width: 800px) {
  body { padding: 1rem .8rem 3rem; }
  h1 { font-size: 1.5rem; }
  .panels { grid-template-columns: minmax(0, 1fr); }
  .advice { padding: .1rem .8rem .8rem; }
  .advice dl { grid-template-columns: 1fr; gap: 0; }
  .advice dd { margin: 0 0 .6rem; }
  th, td { padding: .25rem .35rem; }
  td.verdict, th.verdict { overflow-wrap: break-word; }
  dl.facts { grid-template-columns: 1fr; gap: 0; }
  dl.facts dd { margin: 0 0 .4rem; }
}
@media print {
  body { max-width: none; padding: 0; font-size: 10pt; }
  h2 { break-after: avoid; }
  figure, tr { break-inside: avoid; }
  .wide { overflow: visible; }
  a { color: inherit; text-decoration: none; }
}
)css";

}  // namespace palpate
