// Records of kinds of experiments, into a log and out of a line.
#pragma once

#include "experiments/log/json_line.h"
#include "experiments/log/log.h"

namespace etendue {

template <class Record>
Record read_back(const std::string& line) {
  const Json json = Json::parse(line);
  return dynamic_cast<const Record&>(*read_kind_record(json.at("type"), json));
}

template <class Record>
Record& add_record(RunLog& log, const Record& record) {
  log.records.push_back(std::make_shared<Record>(record));
  return static_cast<Record&>(*log.records.back());
}

}  // namespace etendue
