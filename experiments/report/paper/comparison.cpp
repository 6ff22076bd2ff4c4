#include "experiments/report/paper/comparison.h"

#include "experiments/log/trust.h"
#include "experiments/report/report.h"
#include "experiments/report/report_data.h"
#include "experiments/report/report_text.h"
#include "framework/core/error.h"
#include "framework/core/units.h"
#include "framework/image/metrics.h"
#include "framework/io/image/exr.h"
#include "framework/io/whole_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>

namespace etendue {

namespace {

namespace fs = std::filesystem;

constexpr Colour frame_colours[] = {{0xe6, 0x9f, 0x00}, {0x00, 0x72, 0xb2}, {0x00, 0x9e, 0x73},
                                    {0xcc, 0x79, 0xa7}, {0xd5, 0x5e, 0x00}, {0x56, 0xb4, 0xe9}};
constexpr std::size_t most_windows = std::size(frame_colours);

struct Column {
  std::string name, detail;
  Image image;
  bool is_reference = false;
};

// --- what is shown ---

const SceneData& find_scene(const ReportData& data, const std::string& name) {
  std::vector<std::string> names;
  for (const SceneData& scene : data.scenes) {
    if (kept_images(scene).empty()) continue;
    if (name.empty() || name == scene.name || name == slug(scene.name)) return scene;
    names.push_back(slug(scene.name));
  }
  if (names.empty())
    throw Error(Location{"--figure"}, "no image is kept there; expected the directory of a run, with its images");
  throw Error(Location{"--scene"}, unknown_name("scene", name, names));
}

Column column_of(const Configuration& configuration, const Replicate& replicate) {
  Column column{configuration.short_integrator, "", read_exr(replicate.cell->image)};
  const CheckpointRecord& last = *replicate.last();
  if (const auto error = find_value(last.metrics, "relmse")) column.detail = "relMSE " + format_figure(*error, 2) + ", ";
  column.detail += format_seconds(last.time_s);
  return column;
}

std::vector<Column> columns_of(const SceneData& scene, const std::vector<std::string>& methods) {
  const std::vector<KeptImage> kept = kept_images(scene);
  std::vector<Column> columns;
  if (methods.empty())
    for (const auto& [configuration, replicate] : kept) columns.push_back(column_of(*configuration, *replicate));
  for (const std::string& method : methods) {
    std::vector<std::string> names;
    const auto found = std::ranges::find_if(kept, [&](const auto& other) {
      const Configuration& c = *other.configuration;
      names.push_back(c.short_integrator);
      return method == c.integrator || method == c.shown_integrator || method == c.short_integrator;
    });
    if (found == kept.end()) throw Error(Location{"--method"}, unknown_name("method", method, names));
    columns.push_back(column_of(*found->configuration, *found->replicate));
  }
  if (scene.reference != nullptr && !scene.reference->file.empty() && is_file(scene.reference->file))
    columns.push_back({"reference", "", read_exr(scene.reference->file), true});
  for (const Column& column : columns)
    if (column.image.size != columns.front().image.size)
      throw Error(Location{"--figure"}, fmt::format("the image of {} has {} x {} pixels, that of {} {} x {}; expected one size",
                                                    column.name, column.image.size.x, column.image.size.y, columns.front().name,
                                                    columns.front().image.size.x, columns.front().image.size.y));
  return columns;
}

// The two windows of a fifth of the image, apart from each other, in which the errors of all methods together are largest.
std::vector<Window> worst_windows(const std::vector<Column>& columns) {
  const ivec2 size = columns.front().image.size, extent = glm::max(ivec2(1), size / 5);
  if (!columns.back().is_reference) return {{(size - extent) / 2, extent}};
  std::vector<std::pair<double, Window>> ranked;
  std::vector<double> errors(columns.front().image.pixels.size(), 0);
  for (const Column& column : columns) {
    const std::vector<double> of = relative_squared_errors(column.image, columns.back().image);
    for (std::size_t i = 0; i < of.size(); ++i) errors[i] += std::min(of[i], 1.0);  // one firefly is no region
  }
  for (int y = 0; y + extent.y <= size.y; y += std::max(1, extent.y / 2))
    for (int x = 0; x + extent.x <= size.x; x += std::max(1, extent.x / 2)) {
      double sum = 0;
      for (int j = y; j < y + extent.y; ++j)
        for (int i = x; i < x + extent.x; ++i) sum += errors[static_cast<std::size_t>(j) * size.x + i];
      ranked.push_back({sum, {{x, y}, extent}});
    }
  std::ranges::stable_sort(ranked, [](const auto& a, const auto& b) { return a.first > b.first; });
  std::vector<Window> windows;
  for (const auto& [sum, window] : ranked) {
    const auto overlaps = [&](const Window& other) {
      return glm::all(glm::lessThan(glm::abs(other.begin - window.begin), window.size));
    };
    if (windows.size() < 2 && std::ranges::none_of(windows, overlaps)) windows.push_back(window);
  }
  return windows;
}

void check_windows(const std::vector<Window>& windows, ivec2 size) {
  if (windows.size() > most_windows)
    throw Error(Location{"--crop"}, fmt::format("{} windows; expected {} at most", windows.size(), most_windows));
  for (const Window& w : windows)
    if (w.begin.x + w.size.x > size.x || w.begin.y + w.size.y > size.y)
      throw Error(Location{"--crop"}, fmt::format("{},{},{},{} leaves the image, which has {} x {} pixels", w.begin.x,
                                                  w.begin.y, w.size.x, w.size.y, size.x, size.y));
}

// --- how it is laid out: columns of `width`, the image, then the windows in a row, then their differences in another ---

struct Layout {
  double width = 0, gap = 0, image_height = 0, window_width = 0, window_height = 0;

  Layout(double column_width, double between, ivec2 size, const std::vector<Window>& windows)
      : width(column_width), gap(between), image_height(column_width * size.y / size.x) {
    const auto count = static_cast<double>(windows.size());
    window_width = (width - (count - 1) * gap) / count;
    for (const Window& window : windows) window_height = std::max(window_height, window_width * window.size.y / window.size.x);
  }
  double left(std::size_t column) const { return static_cast<double>(column) * (width + 2 * gap); }
  double window_left(std::size_t column, std::size_t window) const {
    return left(column) + static_cast<double>(window) * (window_width + gap);
  }
  double windows_top() const { return image_height + gap; }
  double differences_top() const { return windows_top() + window_height + gap; }
  double height() const { return differences_top() + window_height; }
};

const char* scale_text = "Lower row: red is brighter than the reference, blue darker, full at a factor of two.";

Canvas composed(const std::vector<Column>& columns, const std::vector<Window>& windows, double exposure) {
  constexpr int width = 360, gap = 6, heading = 52, footing = 28, scale = 2;
  const ivec2 size = columns.front().image.size;
  const Layout layout(width, gap, size, windows);
  const auto whole = [](double value) { return static_cast<int>(std::lround(value)); };
  Canvas canvas({whole(layout.left(columns.size())) - 2 * gap, heading + whole(layout.height()) + footing});
  const auto fitting = [&](std::string text) {
    while (text_pixels(text, scale) > width && !text.empty()) text.pop_back();
    return text;
  };
  for (std::size_t c = 0; c < columns.size(); ++c) {
    const Column& column = columns[c];
    const int left = whole(layout.left(c));
    canvas.text({left, 2}, fitting(column.name), scale);
    canvas.text({left, 28}, fitting(column.detail), scale);
    canvas.draw(picture_of(column.image, {{0, 0}, size}, {width, whole(layout.image_height)}, exposure), {left, heading});
    for (std::size_t w = 0; w < windows.size(); ++w) {
      const Window& window = windows[w];
      const double zoom = layout.window_width / window.size.x, shrink = layout.width / size.x;
      const ivec2 shown(whole(layout.window_width), whole(zoom * window.size.y));
      const int x = whole(layout.window_left(c, w)), y = heading + whole(layout.windows_top());
      canvas.frame({ivec2(left, heading) + ivec2(glm::round(shrink * dvec2(window.begin))),
                    ivec2(glm::round(shrink * dvec2(window.size)))},
                   frame_colours[w], 2);
      canvas.draw(picture_of(column.image, window, shown, exposure), {x, y});
      canvas.frame({{x, y}, shown}, frame_colours[w], 3);
      if (column.is_reference || !columns.back().is_reference) continue;
      canvas.draw(difference_of(column.image, columns.back().image, window, shown),
                  {x, heading + whole(layout.differences_top())});
    }
  }
  if (columns.back().is_reference) canvas.text({0, canvas.size().y - 22}, scale_text, scale);
  return canvas;
}

// The same in LaTeX, of which the parts are files: `parts` is their folder from here.
std::string document(const std::vector<Column>& columns, const std::vector<Window>& windows, const std::string& parts,
                     double exposure) {
  const ivec2 size = columns.front().image.size;
  const Layout layout(4, 0.07, size, windows);  // centimetres
  std::string text = fmt::format(
      "% white is {:.4g} W/(m^2 sr)\n\\documentclass[border=2pt]{{standalone}}\n\\usepackage{{tikz}}\n\\begin{{document}}\n"
      "\\begin{{tikzpicture}}[x=1cm,y=-1cm,every node/.style={{inner sep=0,outer sep=0}},font=\\small]\n",
      1 / exposure);
  for (std::size_t w = 0; w < windows.size(); ++w) {
    const auto& [red, green, blue] = frame_colours[w];
    text += fmt::format("\\definecolor{{crop{}}}{{HTML}}{{{:02X}{:02X}{:02X}}}\n", w, red, green, blue);
  }
  const auto picture = [&](double x, double y, double width, const std::string& part) {
    text += fmt::format("\\node[anchor=north west] at ({:.4f},{:.4f}) {{\\includegraphics[width={:.4f}cm]{{{}/{}.png}}}};\n", x,
                        y, width, parts, part);
  };
  const auto frame = [&](std::size_t w, dvec2 at, dvec2 extent) {
    text += fmt::format("\\draw[crop{},line width=1pt] ({:.4f},{:.4f}) rectangle +({:.4f},{:.4f});\n", w, at.x, at.y, extent.x,
                        extent.y);
  };
  for (std::size_t c = 0; c < columns.size(); ++c) {
    const double left = layout.left(c);
    text += fmt::format(
        "\\node[anchor=south west,align=left,text width={:.4f}cm] at ({:.4f},-0.08) {{{}\\\\{{\\scriptsize {}\\strut}}}};\n",
        layout.width, left, escape_tex(columns[c].name), escape_tex(columns[c].detail));
    picture(left, 0, layout.width, fmt::format("{}", c));
    for (std::size_t w = 0; w < windows.size(); ++w) {
      const Window& window = windows[w];
      const double x = layout.window_left(c, w), height = layout.window_width * window.size.y / window.size.x;
      frame(w, dvec2(left, 0) + layout.width / size.x * dvec2(window.begin), layout.width / size.x * dvec2(window.size));
      picture(x, layout.windows_top(), layout.window_width, fmt::format("{}-{}", c, w));
      frame(w, {x, layout.windows_top()}, {layout.window_width, height});
      if (!columns[c].is_reference && columns.back().is_reference)
        picture(x, layout.differences_top(), layout.window_width, fmt::format("{}-{}-difference", c, w));
    }
  }
  if (columns.back().is_reference)
    text +=
        fmt::format("\\node[anchor=north west,font=\\scriptsize] at (0,{:.4f}) {{{}}};\n", layout.height() + 0.1, scale_text);
  return text + "\\end{tikzpicture}\n\\end{document}\n";
}

}  // namespace

std::vector<KeptImage> kept_images(const SceneData& scene) {
  std::map<std::size_t, KeptImage> kept;
  for (const Configuration& configuration : scene.configurations)
    for (const Replicate& replicate : configuration.replicates)
      if (!replicate.cell->image.empty())
        kept.try_emplace(configuration.integrator_index, KeptImage{&configuration, &replicate});
  return values_of(kept);
}

Comparison write_comparison(const std::vector<std::string>& directories, const std::string& file,
                            const ComparisonChoice& choice) {
  Comparison written;
  std::vector<RunLog> logs;
  for (const std::string& directory : directories) {
    logs.push_back(read_resolved_log(directory));
    for (std::string& note : distrust(logs.back(), "", false)) written.notes.push_back(std::move(note));
  }
  const RunLog log = merge_logs(logs);
  const ReportData data = arrange(log);
  const std::vector<Column> columns = columns_of(find_scene(data, choice.scene), choice.methods);
  const std::vector<Window> windows = choice.windows.empty() ? worst_windows(columns) : choice.windows;
  const ivec2 size = columns.front().image.size;
  check_windows(windows, size);
  const double exposure = 1 / white_of(columns.back().image);

  const fs::path png(file), parts = fs::path(png).replace_extension("") += "-parts";
  const auto write = [&](const fs::path& path, const std::string& text) {
    make_folders(path.parent_path().string());
    write_whole_file(path.string(), text);
    written.files.push_back(path.string());
  };
  write(png, composed(columns, windows, exposure).png());
  write(fs::path(png).replace_extension(".tex"), document(columns, windows, parts.filename().string(), exposure));
  for (std::size_t c = 0; c < columns.size(); ++c) {
    write(parts / fmt::format("{}.png", c), picture_of(columns[c].image, {{0, 0}, size}, size, exposure).png());
    for (std::size_t w = 0; w < windows.size(); ++w) {
      const Window& window = windows[w];
      const ivec2 shown = std::max(1, 400 / window.size.x) * window.size;  // repeated, lest a viewer blurs the pixels
      write(parts / fmt::format("{}-{}.png", c, w), picture_of(columns[c].image, window, shown, exposure).png());
      if (!columns[c].is_reference && columns.back().is_reference)
        write(parts / fmt::format("{}-{}-difference.png", c, w),
              difference_of(columns[c].image, columns.back().image, window, shown).png());
    }
  }
  return written;
}

}  // namespace etendue
