// The style and script of report.html, without any external resource.
#pragma once

#include <string_view>

namespace etendue {

extern const std::string_view report_style;
extern const std::string_view report_script;

}  // namespace etendue
