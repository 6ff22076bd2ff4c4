// `etendue convert`: a scene of any kind as a pbrt file, with its meshes and images beside it.
#include "experiments/command/commands.h"
#include "experiments/command/console.h"
#include "experiments/log/json_line.h"
#include "framework/io/load_scene.h"
#include "framework/io/pbrt/write.h"
#include "framework/io/whole_file.h"

#include <fmt/format.h>

#include <filesystem>

namespace etendue {

namespace {

namespace fs = std::filesystem;

// Before anything is read. A scene that is written over itself would lose what it cannot say.
void check_output(const ConvertCommand& command) {
  const Location where{command.output};
  if (fs::path(command.output).extension() != ".pbrt" || fs::path(command.output).stem().empty())
    throw Error(where, "unknown scene format; expected a name that ends in .pbrt");
  check_writable(command.output, {"OUT " + command.output});
  std::error_code ignored;
  if (fs::equivalent(command.scene, command.output, ignored)) throw Error(where, "is the scene itself; expected another file");
}

}  // namespace

int convert_command(const ConvertCommand& command) {
  Console console;
  exit_on_interrupt("\ninterrupted; no scene is written\n");
  check_output(command);
  const Scene scene = load_scene(command.scene, {"command line"}, command.reading);
  for (const std::string& warning : scene.warnings) console.warning(warning);

  const fs::path output(command.output), parent = output.parent_path();
  const std::string folder = output.stem().string() + "-files";
  std::vector<std::string> files;
  const PbrtText written = write_pbrt(scene, folder, [&](const std::string& name, std::string_view bytes) {
    if (files.empty()) make_folders((parent / folder).string());
    const std::string path = (parent / name).string();
    console.status("writing " + path);
    write_whole_file(path, bytes);
    files.push_back(path);
  });
  write_whole_file(command.output, written.text);
  console.clear_status();
  for (const std::string& warning : written.warnings) console.warning(command.scene + ": " + warning);

  if (command.json)
    fmt::print("{}\n", dump(Json{{"scene", command.output}, {"files", files}, {"warnings", written.warnings}}, 2));
  else {
    fmt::print("scene       {}\n", command.output);
    if (!files.empty()) fmt::print("files       {} in {}\n", files.size(), (parent / folder).string());
  }
  return 0;
}

}  // namespace etendue
