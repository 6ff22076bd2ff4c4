// The files of the page as the build embeds them (embed.cmake): page.css as page_css.
#pragma once

#include <string_view>

namespace etendue {

extern const std::string_view page_html, page_css, chart_css, chart_file_css;
extern const std::string_view page_js, charts_js, tables_js, pixels_js, viewer_js, panes_js, start_js;  // in this order

}  // namespace etendue
