#include "experiments/report/page/assets.h"

namespace etendue {

// Series colours are Okabe and Ito's palette ([Okabe2008]), yellow darkened on white and blue and black lightened on dark.
const std::string_view report_style = R"css(
:root{color-scheme:light dark;--page:#fdfdfc;--card:#fff;--ink:#1c1e21;--muted:#5a6068;--rule:#dadde0;--faint:#eef0f1;--grid:#e3e5e7;
--minor:#f2f3f4;--accent:#005f96;--warn:#8a4b00;--warn-back:#fff6e6;--context:#c6cacd;
--c0:#0072b2;--c1:#d55e00;--c2:#009e73;--c3:#b8568f;--c4:#c98500;--c5:#3a9bd9;--c6:#000;--c7:#8f8400}
@media (prefers-color-scheme:dark){:root{--page:#14161a;--card:#1a1d22;--ink:#e6e8ea;--muted:#a0a7af;--rule:#353a41;--faint:#22262c;
--grid:#2c3138;--minor:#21252b;--accent:#6cb8ee;--warn:#f0b860;--warn-back:#2a2317;--context:#4b5159;
--c0:#4a9ddb;--c1:#ef8340;--c2:#2fbf95;--c3:#dc93bd;--c4:#efb13c;--c5:#8fd0f7;--c6:#f2f2f2;--c7:#e9de58}}
*{box-sizing:border-box}
html{scroll-padding-top:4.2rem}
body{margin:0 auto;max-width:1280px;padding:0 1.25rem 4rem;background:var(--page);color:var(--ink);
font:15px/1.5 -apple-system,"Segoe UI",Roboto,"Helvetica Neue",Arial,"Liberation Sans",sans-serif;overflow-wrap:anywhere}
h1{font-size:1.75rem;line-height:1.2;margin:2rem 0 .3rem}
h2{font-size:1.3rem;margin:2.6rem 0 .6rem;padding-top:.6rem;border-top:1px solid var(--rule)}
h3{font-size:1rem;margin:1.4rem 0 .4rem}
a{color:var(--accent)}
:focus-visible{outline:2px solid var(--accent);outline-offset:2px}
.facts,.note,figcaption small,.caption,.none{color:var(--muted)}
.facts{margin:.2rem 0 0}
.note,.notes{font-size:.82rem;color:var(--muted);margin:.3rem 0}
.notes{padding-left:1.1rem}
nav{display:flex;flex-wrap:wrap;gap:.2rem 1rem;margin:1rem 0;font-size:.92rem}
.findings{display:grid;gap:1rem;grid-template-columns:repeat(auto-fit,minmax(min(100%,26rem),1fr))}
.card{background:var(--card);border:1px solid var(--rule);border-radius:8px;padding:.8rem 1rem}
.card h3{margin:0 0 .4rem}
.card dl{margin:0;display:grid;grid-template-columns:minmax(6.2rem,auto) 1fr;gap:.35rem .8rem;font-size:.92rem}
.card dt{color:var(--muted)}
.card dd{margin:0}
.warnings{background:var(--warn-back);border:1px solid var(--rule);border-left:4px solid var(--warn);border-radius:6px;
padding:.6rem 1rem;margin:1rem 0;font-size:.92rem}
.warnings h3{margin:0;color:var(--warn)}
.warnings ul{margin:.3rem 0 0;padding-left:1.1rem}
.toolbar{position:sticky;top:0;z-index:3;display:flex;flex-wrap:wrap;gap:.4rem 1.4rem;align-items:center;background:var(--page);
border-bottom:1px solid var(--rule);padding:.55rem 0;font-size:.9rem}
.toolbar fieldset{border:0;margin:0;padding:0;display:flex;gap:.6rem;align-items:center}
.toolbar legend{float:left;margin-right:.5rem;color:var(--muted)}
select,input,button{font:inherit;color:inherit}
select,input[type=search]{background:var(--card);border:1px solid var(--rule);border-radius:5px;padding:.2rem .4rem;max-width:100%}
input[type=range],input[type=radio]{accent-color:var(--accent)}
.figures{display:grid;gap:1.6rem 2rem;grid-template-columns:repeat(auto-fit,minmax(min(100%,440px),1fr));align-items:start}
figure{margin:0;min-width:0;position:relative}
figure.wide{grid-column:1/-1}
figcaption{font-weight:600;margin:.2rem 0}
@media (min-width:900px){figure.wide+figure.chart{grid-column:1/-1;display:grid;grid-template-columns:minmax(0,44rem) 1fr;gap:0 1.5rem}
figure.wide+figure.chart ul.legend{flex-direction:column;align-self:center}}
.panels{display:grid;gap:.6rem;grid-template-columns:1fr}
.wide .panels{grid-template-columns:repeat(auto-fit,minmax(min(100%,330px),1fr))}
svg.chart{display:block;width:100%;height:auto;touch-action:pan-y}
svg text{font-size:13px;fill:var(--ink)}
svg .grid{stroke:var(--grid)}svg .minor{stroke:var(--minor)}svg .zero{stroke:var(--muted)}svg .frame{stroke:var(--context)}
svg .leader{stroke:var(--context)}svg .label{stroke:var(--page)}
.c0{color:var(--c0)}.c1{color:var(--c1)}.c2{color:var(--c2)}.c3{color:var(--c3)}.c4{color:var(--c4)}.c5{color:var(--c5)}
.c6{color:var(--c6)}.c7{color:var(--c7)}.context{color:var(--context)}.stairs{color:var(--ink)}
.series.hidden{display:none}
.cursor{fill:none;stroke:var(--ink);stroke-width:1.5;pointer-events:none}
ul.legend{list-style:none;display:flex;flex-wrap:wrap;gap:.1rem .4rem;margin:.3rem 0;padding:0}
ul.legend button{display:flex;align-items:center;gap:.4rem;border:0;background:none;padding:.15rem .35rem;border-radius:5px;
font-size:.85rem;cursor:pointer;text-align:left}
ul.legend button:hover{background:var(--faint)}
ul.legend button[aria-pressed=false]{opacity:.42;text-decoration:line-through}
.swatch{flex:none}
.tip{position:absolute;z-index:4;pointer-events:none;background:var(--card);border:1px solid var(--rule);border-radius:6px;
padding:.35rem .6rem;font-size:.82rem;line-height:1.35;box-shadow:0 2px 8px #0003;max-width:18rem}
.tip b{display:block}
.tip:empty{display:none}
.scroll{overflow:auto;max-height:36rem;border:1px solid var(--rule);border-radius:6px}
table{border-collapse:collapse;font-size:.84rem;width:100%;overflow-wrap:normal}
th,td{padding:.28rem .6rem;text-align:left;vertical-align:top}
td{border-top:1px solid var(--faint)}
td:not(.num){min-width:4rem;max-width:30rem}
.name{white-space:nowrap}
td:not(.num):not(.name){min-width:14rem}
.num{text-align:right;font-variant-numeric:tabular-nums;white-space:nowrap}
thead th{position:sticky;top:0;background:var(--faint);white-space:nowrap}
th button{border:0;background:none;padding:0;font-weight:600;cursor:pointer}
th button::after{content:"";display:inline-block;width:.9em;text-align:right}
th[aria-sort=ascending] button::after{content:"▲";font-size:.7em}
th[aria-sort=descending] button::after{content:"▼";font-size:.7em}
tbody tr:hover{background:var(--faint)}
figure.table{margin:1.2rem 0}
figure.table figcaption{display:flex;flex-wrap:wrap;justify-content:space-between;gap:.5rem;align-items:center}
figure.table input{font-weight:400;font-size:.84rem}
.viewer{margin-top:1.4rem}
.controls{display:flex;flex-wrap:wrap;gap:.4rem 1.2rem;align-items:center;font-size:.88rem;margin:.3rem 0 .6rem}
.controls label{display:flex;gap:.4rem;align-items:center;color:var(--muted)}
.controls output{min-width:4.2em;font-variant-numeric:tabular-nums}
.panes{display:grid;gap:1rem 2rem;grid-template-columns:repeat(auto-fit,minmax(min(100%,380px),1fr));align-items:start}
.frame-box{overflow:auto;max-height:44rem;border:1px solid var(--rule);background:#000;border-radius:4px}
.canvas{position:relative;width:100%;line-height:0;cursor:ew-resize;touch-action:pan-y}
.canvas img{width:100%;height:auto;image-rendering:pixelated;user-select:none;-webkit-user-drag:none}
.canvas .over{position:absolute;inset:0;clip-path:inset(0 calc(100% - var(--wipe,50%)) 0 0)}
.divider{position:absolute;top:0;bottom:0;left:var(--wipe,50%);width:2px;margin-left:-1px;background:#fff;box-shadow:0 0 2px #000}
.pane.map .canvas{cursor:default}
.wipe{width:100%;margin:.4rem 0 0}
.caption{font-size:.82rem;margin:.25rem 0;display:flex;flex-wrap:wrap;justify-content:space-between;gap:.2rem 1rem}
.colourbar{height:12px;border-radius:3px;margin-top:.5rem}
.ticks{display:flex;justify-content:space-between;font-size:.78rem;color:var(--muted);font-variant-numeric:tabular-nums}
.sheet{display:grid;grid-template-columns:repeat(auto-fill,minmax(min(45%,150px),1fr));gap:.5rem;margin-top:.8rem;
align-items:start}
.sheet button{display:block;border:2px solid transparent;border-radius:6px;background:none;padding:2px;cursor:pointer;font-size:.76rem;line-height:1.3;
text-align:left}
.sheet button[aria-pressed=true]{border-color:var(--accent)}
.sheet span{display:block}.sheet .note{margin:0;font-size:.95em}
.sheet img{width:100%;display:block;image-rendering:pixelated;border-radius:3px;margin-bottom:.2rem;background:#000}
pre{background:var(--faint);border-radius:6px;padding:.7rem .9rem;overflow:auto;font:.84rem/1.45 ui-monospace,"DejaVu Sans Mono",monospace}
details{margin:.6rem 0}
summary{cursor:pointer}
@media (max-width:640px){
body{padding:0 .8rem 3rem}
svg text{font-size:19px}svg .label{font-size:16px}svg .axis-title,svg .panel-title{font-size:19px}
.toolbar{position:static}
.card dl{grid-template-columns:1fr;gap:0}.card dd{margin-bottom:.5rem}
.wide svg text{font-size:16px}
}
@media print{.toolbar,.controls,.sheet,nav{display:none}.scroll{max-height:none;overflow:visible}}
)css";

}  // namespace etendue
