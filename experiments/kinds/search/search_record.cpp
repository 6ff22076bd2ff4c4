#include "experiments/kinds/search/search_record.h"

#include "experiments/log/fields.h"

namespace etendue {

void list_fields(auto& f, FieldsOf<SearchFigure> auto& r) {
  f("structure", r.structure);
  f("measure", r.measure);
  f("parameter", r.parameter);
  f("value", r.value.median);
  f("low", r.value.low);
  f("high", r.value.high);
  f("found", r.found);
}

void list_fields(auto& f, FieldsOf<SearchRecord> auto& r) {
  f.cell(r.cell, "accel", "size");
  list_ending(f, r);
  f("kind", r.kind);
  f("set", r.set);
  f("varies", r.varies);
  f("variation", r.variation);
  f("count", r.count);
  f("checked", r.checked);
  f("disagreements", r.disagreements);
  f("figures", r.figures);
}

std::string SearchRecord::line() const { return line_of("search", *this); }
SearchRecord read_search_record(const Json& json) { return read_value<SearchRecord>(json); }

}  // namespace etendue
