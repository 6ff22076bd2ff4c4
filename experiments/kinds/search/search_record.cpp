#include "experiments/kinds/search/search_record.h"

#include "experiments/log/json_line.h"

namespace etendue {

std::string to_json_line(const SearchRecord& r) {
  Json figures = Json::array();
  for (const SearchFigure& f : r.figures)
    figures.push_back(Json{{"structure", f.structure},
                           {"measure", f.measure},
                           {"parameter", finite(f.parameter)},
                           {"value", finite(f.value.median)},
                           {"low", finite(f.value.low)},
                           {"high", finite(f.value.high)},
                           {"found", finite(f.found)}});
  const Json json{{"type", "search"},
                  {"scene", r.cell.scene},
                  {"accel", r.cell.accel},
                  {"size", r.cell.integrator},
                  {"seed", r.cell.seed},
                  {"manifest", r.manifest},
                  {"status", r.status},
                  {"error", r.error},
                  {"kind", r.kind},
                  {"set", r.set},
                  {"varies", r.varies},
                  {"variation", finite(r.variation)},
                  {"count", r.count},
                  {"checked", r.checked},
                  {"disagreements", r.disagreements},
                  {"figures", std::move(figures)}};
  return dump(json);
}

SearchRecord read_search_line(const std::string& line) {
  const Json json = Json::parse(line);
  SearchRecord r;
  r.cell = {json.at("scene"), json.at("accel"), json.at("size"), json.at("seed").get<std::uint64_t>()};
  r.manifest = json.at("manifest");
  r.status = json.at("status");
  r.error = json.at("error");
  r.kind = json.at("kind");
  r.set = json.at("set");
  r.varies = json.at("varies");
  r.variation = json.at("variation");
  r.count = json.at("count");
  r.checked = json.at("checked");
  r.disagreements = json.at("disagreements");
  for (const Json& f : json.at("figures"))
    r.figures.push_back(
        {f.at("structure"), f.at("measure"), f.at("parameter"), {f.at("value"), f.at("low"), f.at("high")}, f.at("found")});
  return r;
}

}  // namespace etendue
