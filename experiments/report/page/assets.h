// The files of the page as the build embeds them (embed.cmake): page.css as page_css.
#pragma once

#include <string_view>

namespace etendue {

extern const std::string_view page_html, page_css, page_js, chart_css, chart_file_css;

}  // namespace etendue
