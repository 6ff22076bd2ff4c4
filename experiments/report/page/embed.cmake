# Writes OUTPUT, a source that holds FILES of SOURCE as text (assets.h).
set(text "#include \"experiments/report/page/assets.h\"\n\nnamespace etendue {\n\n")
foreach(file ${FILES})
  file(READ ${SOURCE}/${file} content)
  string(REPLACE "." "_" name ${file})
  string(APPEND text "const std::string_view ${name} = R\"page(${content})page\";\n")
endforeach()
file(WRITE ${OUTPUT} "${text}\n}  // namespace etendue\n")
