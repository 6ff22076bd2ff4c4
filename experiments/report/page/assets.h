// page.html, page.css and page.js as the build embeds them (embed.cmake).
#pragma once

#include <string_view>

namespace etendue {

extern const std::string_view page_html, page_css, page_js;

}  // namespace etendue
