# Writes OUTPUT, a source that holds page.html, page.css and page.js of SOURCE as text (assets.h).
set(text "#include \"experiments/report/page/assets.h\"\n\nnamespace etendue {\n\n")
foreach(name html css js)
  file(READ ${SOURCE}/page.${name} content)
  string(APPEND text "const std::string_view page_${name} = R\"page(${content})page\";\n")
endforeach()
file(WRITE ${OUTPUT} "${text}\n}  // namespace etendue\n")
