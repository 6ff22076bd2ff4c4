// Figures for papers: crops of what a run kept, charts for pgfplots, and LaTeX that compiles where it is installed.
#include "experiments/report/charts/charts.h"
#include "experiments/report/paper/comparison.h"
#include "framework/io/image/image_file.h"
#include "tests/unit/harness_process.h"

#include <algorithm>
#include <cstdlib>

namespace etendue {
namespace {

TEST(PaperPictures, AverageWhenSmallerAndRepeatWhenLarger) {
  Image image({4, 2});
  for (int x = 0; x < 4; ++x)
    for (int y = 0; y < 2; ++y) image.at(x, y) = dvec3(x < 2 ? 0 : 1);
  image.at(1, 0) = dvec3(1);
  const auto pixels = [](const Canvas& canvas) { return decode_image(canvas.png(), "png", Encoding::linear).texels; };
  const auto small = pixels(picture_of(image, {{0, 0}, {4, 2}}, {2, 1}, 1)),
             large = pixels(picture_of(image, {{1, 0}, {2, 1}}, {4, 2}, 1));
  EXPECT_NEAR(small[0].x, 0.537, 0.003);  // a quarter, on sRGB's curve
  EXPECT_EQ(small[1].x, 1);
  for (const Rgb& texel : large) EXPECT_EQ(texel.x, 1);
}

TEST(PaperPictures, DifferencesAreSigned) {
  EXPECT_EQ(difference_colour(dvec3(0.5), dvec3(0.5), 1), (Colour{255, 255, 255}));
  EXPECT_EQ(difference_colour(dvec3(2), dvec3(0.5), 1), (Colour{255, 0, 0}));
  EXPECT_EQ(difference_colour(dvec3(0.1), dvec3(0.5), 1), (Colour{0, 0, 255}));
  EXPECT_EQ(difference_colour(dvec3(NAN), dvec3(0.5), 1), (Colour{128, 128, 128}));
  const Colour brighter = difference_colour(dvec3(1.1), dvec3(1), 1);
  EXPECT_EQ(brighter[0], 255);
  EXPECT_GT(brighter[1], 200);
}

// Whatever the unit of the scene: what is dark is so beside its white.
TEST(PaperPictures, DifferencesAreFullAtAFactorOfTwoInDimScenes) {
  EXPECT_EQ(difference_colour(dvec3(2.1e-5), dvec3(1e-5), 2e-5), (Colour{255, 0, 0}));
  Image dim({2, 2}), bright({2, 2});
  std::ranges::fill(dim.pixels, dvec3(1e-5));
  std::ranges::fill(bright.pixels, dvec3(2.1e-5));
  const Canvas canvas = difference_of(bright, dim, {{0, 0}, {2, 2}}, {2, 2});
  const auto texels = decode_image(canvas.png(), "png", Encoding::linear).texels;
  for (const Rgb& texel : texels) EXPECT_EQ(texel, Rgb(1, 0, 0));
}

TEST(PaperCharts, PointsOfAllSeriesAreInOneTable) {
  Chart chart{.title = "50% of_it", .x = {"time (s)"}, .y = {"relMSE"}};
  ChartSeries path{.key = "a", .label = "path"}, band{.key = "b", .label = "sppm & more"};
  path.points = {{1, 0.1}, {2, 0}, {3, 0.1, 1e-9, 0.2}};
  band.style(1);
  band.points = {{1, 0.1, 0.05, 0.2}, {2, 0.01, 0.005, 0.02}};
  chart.series = {path, band};
  const Figure figure{.name = "f", .title = "t", .panels = {chart}};
  const std::string data = pgfplots_data(figure), text = to_pgfplots(figure, "f.dat");
  EXPECT_TRUE(data.starts_with("series x y low high\n# 0: 50% of_it: path\n0 1 0.1 0.1 0.1\n0 2 ")) << data;
  EXPECT_EQ(data.find("\n0 2 0 "), std::string::npos) << "a log axis has no zero";
  EXPECT_NE(data.find("\n0 3 0.1 1e-09 0.2\n"), std::string::npos) << "what lies beyond the axis is what it is: " << data;
  EXPECT_NE(data.find("\n1 2 0.01 0.005 0.02\n"), std::string::npos) << data;
  for (const char* part :
       {"title={50\\% of\\_it}", "xmode=log", "fill between[of=low1 and high1]", "{path}", "{sppm \\& more}"})
    EXPECT_NE(text.find(part), std::string::npos) << part;
}

class Paper : public ProgramTest {
 protected:
  void SetUp() override {
    ProgramTest::SetUp();
    write_file("e.toml",
               "scenes = [\"builtin:lambert-sphere\"]\nbudget = { samples = 4 }\nresolution = [40, 30]\nseeds = 2\n"
               "integrators = [{ name = \"path\", label = \"50% of it\" }, \"light-trace\"]\n");
    const Outcome outcome = run({"run", "e.toml"});
    ASSERT_EQ(outcome.status, 0) << outcome.err;
  }
  std::string refusal(std::vector<std::string> more) {
    more.insert(more.begin(), {"report", "out/e", "--figure", "f.png"});
    const Outcome refused = run(more);
    EXPECT_EQ(refused.status, 2);
    return refused.err;
  }
};

TEST_F(Paper, FigureShowsMethodsWindowsAndDifferences) {
  const Outcome made = run({"report", "out/e", "--figure", "paper/f.png", "--crop", "2,3,10,10", "--crop", "20,10,8,16",
                            "--method", "light-trace", "--method", "50% of it"});
  EXPECT_EQ(made.status, 0) << made.err;
  EXPECT_TRUE(made.out.starts_with("paper/f.png\npaper/f.tex\npaper/f-parts/0.png\n")) << made.out;
  const RgbImage png = read_image((directory_ / "paper/f.png").string());
  EXPECT_EQ(png.size.x, 3 * 360 + 2 * 12);
  const std::string tex = read_text_file(directory_ / "paper/f.tex");
  EXPECT_LT(tex.find("light-trace"), tex.find("50\\% of it"));
  EXPECT_LT(tex.find("50\\% of it"), tex.find("reference"));
  EXPECT_NE(tex.find("{f-parts/1-1-difference.png}"), std::string::npos) << tex;
  EXPECT_EQ(read_image((directory_ / "paper/f-parts/0-1.png").string()).size, ivec2(400, 800));
  EXPECT_EQ(read_image((directory_ / "paper/f-parts/2.png").string()).size, ivec2(40, 30));
}

TEST_F(Paper, FigureOfWhatIsNotThereIsRefused) {
  EXPECT_NE(refusal({"--method", "light-trac"}).find("did you mean 'light-trace'"), std::string::npos);
  EXPECT_NE(refusal({"--scene", "lambert-spere"}).find("did you mean 'lambert-sphere'"), std::string::npos);
  EXPECT_NE(refusal({"--crop", "35,0,10,10"}).find("leaves the image, which has 40 x 30 pixels"), std::string::npos);
  std::filesystem::remove_all(directory_ / "out/e/images");
  EXPECT_NE(refusal({}).find("no image is kept there"), std::string::npos);
}

class LongPaper : public Paper {
 protected:
  void compile(const std::string& folder, const std::string& name) {
    const std::string command = "cd '" + (directory_ / folder).string() +
                                "' && pdflatex -interaction=nonstopmode -halt-on-error '" + name + ".tex' >latex.txt 2>&1";
    EXPECT_EQ(std::system(command.c_str()), 0) << read_text_file(directory_ / folder / "latex.txt");
    EXPECT_TRUE(std::filesystem::exists(directory_ / folder / (name + ".pdf")));
  }
};

TEST_F(LongPaper, LatexCompiles) {
  if (!is_installed("pdflatex")) GTEST_SKIP() << "pdflatex is not installed";
  ASSERT_EQ(run({"report", "out/e", "--figure", "f.png"}).status, 0);
  compile(".", "f");
  const Outcome report = run({"report", "out/e", "--latex"});
  ASSERT_EQ(report.status, 0) << report.err;
  int charts = 0;
  for (const auto& entry : std::filesystem::directory_iterator(directory_ / "out/e/latex"))
    if (entry.path().extension() == ".tex" && ++charts <= 3) compile("out/e/latex", entry.path().stem().string());
  EXPECT_GT(charts, 0);
  std::string tables = "\\documentclass{article}\n\\usepackage{booktabs,adjustbox}\n\\begin{document}\n";
  for (const auto& entry : std::filesystem::directory_iterator(directory_ / "out/e/tables"))
    if (entry.path().extension() == ".tex") tables += "\\input{" + entry.path().stem().string() + "}\n";
  write_file("out/e/tables/all.tex", tables + "\\end{document}\n");
  compile("out/e/tables", "all");
  EXPECT_EQ(read_text_file(directory_ / "out/e/tables/latex.txt").find("Overfull"), std::string::npos) << "a table is cut off";
}

}  // namespace
}  // namespace etendue
