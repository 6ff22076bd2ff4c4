#include "framework/io/image/exr.h"
#include "framework/io/image/image_file.h"
#include "framework/io/image/octahedral.h"
#include "tests/unit/io_helpers.h"

#include <cstring>

namespace etendue {
namespace {

Image gradient(ivec2 size) {
  Image image(size);
  for (int y = 0; y < size.y; ++y)
    for (int x = 0; x < size.x; ++x) image.at(x, y) = {0.25 * x, 1e6 * y, -1.0 / (1 + x + y)};
  return image;
}

template <class T>
std::string raw(T value) {
  std::string bytes(sizeof value, '\0');
  std::memcpy(bytes.data(), &value, sizeof value);
  return bytes;
}

enum class PixelType : std::int32_t { uint, half, single };
struct Channel {
  std::string name;
  PixelType type;
  std::int32_t sampling = 1;
};

// An uncompressed scan-line file written by hand: value 1 in the first channel, 0.5 (or 2, for whole numbers) in the others.
std::string plain_exr(const std::vector<Channel>& channels, ivec2 origin, ivec2 size,
                      const std::vector<float>& chromaticities = {}) {
  const auto attribute = [](const std::string& name, const std::string& type, const std::string& value) {
    return name + '\0' + type + '\0' + raw(static_cast<std::int32_t>(value.size())) + value;
  };
  std::string list, line;
  for (const Channel& c : channels) {
    const bool first = &c == channels.data();
    list += c.name + '\0' + raw(c.type) + raw(std::int32_t{0}) + raw(c.sampling) + raw(c.sampling);
    for (int x = 0; x < size.x; ++x)
      line += c.type == PixelType::half   ? raw(static_cast<std::uint16_t>(first ? 0x3c00 : 0x3800))
              : c.type == PixelType::uint ? raw(std::uint32_t{first ? 1u : 2u})
                                          : raw(first ? 1.0f : 0.5f);
  }
  const std::string window = raw(origin.x) + raw(origin.y) + raw(origin.x + size.x - 1) + raw(origin.y + size.y - 1);
  std::string file = std::string("\x76\x2f\x31\x01", 4) + raw(std::int32_t{2}) + attribute("channels", "chlist", list + '\0') +
                     attribute("compression", "compression", std::string(1, '\0')) + attribute("dataWindow", "box2i", window) +
                     attribute("displayWindow", "box2i", window) + attribute("lineOrder", "lineOrder", std::string(1, '\0')) +
                     attribute("pixelAspectRatio", "float", raw(1.0f)) +
                     attribute("screenWindowCenter", "v2f", raw(0.0f) + raw(0.0f)) +
                     attribute("screenWindowWidth", "float", raw(1.0f)) + '\0';
  if (!chromaticities.empty()) {
    std::string values;
    for (const float value : chromaticities) values += raw(value);
    file.pop_back();
    file += attribute("chromaticities", "chromaticities", values) + '\0';
  }
  const std::uint64_t data = file.size() + 8 * static_cast<std::uint64_t>(size.y), chunk = 8 + line.size();
  for (int y = 0; y < size.y; ++y) file += raw(data + chunk * static_cast<std::uint64_t>(y));
  for (int y = 0; y < size.y; ++y) file += raw(origin.y + y) + raw(static_cast<std::int32_t>(line.size())) + line;
  return file;
}

// Runs and rows of a TGA of 64 x 2 grey pixels.
TEST(ImageFile, CutShortIsRefused) {
  std::string runs("\0\0\x0b\0\0\0\0\0\0\0\0\0\x40\0\x02\0\x08\0", 18), rows = runs;
  rows[2] = 3;
  for (int row = 0; row < 2; ++row) {
    runs += std::string("\xbf\x80", 2);
    rows += std::string(64, '\x80');
  }
  for (const std::string& whole : {runs, rows}) {
    const RgbImage image = decode_image(whole, "i.tga", Encoding::linear);
    ASSERT_EQ(image.size, ivec2(64, 2));
    for (const Rgb& texel : image.texels) EXPECT_EQ(texel, Rgb(128.0f / 255));
    for (std::size_t size = 0; size < whole.size(); ++size)
      EXPECT_THROW(decode_image(whole.substr(0, size), "i.tga", Encoding::linear), Error) << size;
  }
}

// Rows go from the bottom, each padded to four bytes; channels are blue, green, red.
TEST(ImageFile, BmpIsRead) {
  const std::string header("BM\x46\0\0\0\0\0\0\0\x36\0\0\0\x28\0\0\0\2\0\0\0\2\0\0\0\1\0\x18\0", 30);
  const std::string rows("\xff\0\0\0\xff\0\0\0\0\0\xff\xff\xff\xff\0\0", 16);
  const std::string whole = header + std::string(24, '\0') + rows;
  const RgbImage image = decode_image(whole, "i.bmp");
  ASSERT_EQ(image.size, ivec2(2, 2));
  EXPECT_EQ(image.texels, (std::vector<Rgb>{{1, 0, 0}, {1, 1, 1}, {0, 0, 1}, {0, 1, 0}}));
  for (std::size_t size = 0; size + 2 < whole.size(); ++size)
    EXPECT_THROW(decode_image(whole.substr(0, size), "i.bmp"), Error) << size;
}

TEST(ImageFile, AlphaIsReadWhereItIsWanted) {
  const std::string header("\0\0\2\0\0\0\0\0\0\0\0\0\2\0\1\0\x20\x28", 18), texels("\0\0\xff\xff\xff\xff\xff\0", 8);
  EXPECT_EQ(decode_image(header + texels, "i.tga").texels, (std::vector<Rgb>{{1, 0, 0}, {1, 1, 1}}));
  EXPECT_EQ(decode_image(header + texels, "i.tga", Encoding::alpha).texels, (std::vector<Rgb>{Rgb(1), Rgb(0)}));
  const std::uint8_t black[3] = {};
  const auto png = encode_png(black, {1, 1});
  EXPECT_EQ(decode_image(std::string(png.begin(), png.end()), "i.png", Encoding::alpha).texels.at(0), Rgb(1))
      << "without alpha";
  const std::string exr = plain_exr(
      {{"A", PixelType::half}, {"B", PixelType::half}, {"G", PixelType::half}, {"R", PixelType::half}}, {0, 0}, {1, 1});
  EXPECT_EQ(decode_image(exr, "i.exr", Encoding::alpha).texels.at(0), Rgb(1));
  EXPECT_EQ(decode_image(exr, "i.exr").texels.at(0), Rgb(0.5f));
  const std::string chroma =
      plain_exr({{"BY", PixelType::half}, {"RY", PixelType::half}, {"Y", PixelType::half}}, {0, 0}, {1, 1});
  EXPECT_ERROR(decode_image(chroma, "i.exr"), "luminance and chroma, BY, RY, Y; expected channels R, G and B, or Y alone");
  const std::string after =
      plain_exr({{"@", PixelType::half}, {"A", PixelType::half}, {"Y", PixelType::single}}, {0, 0}, {1, 1});
  EXPECT_EQ(decode_image(after, "i.exr", Encoding::alpha).texels.at(0), Rgb(0.5f));
  EXPECT_EQ(decode_image(plain_exr({{"Y", PixelType::half}}, {0, 0}, {1, 1}), "i.exr", Encoding::alpha).texels.at(0), Rgb(1));
}

TEST(Exr, RoundTripKeepsSinglePrecisionAndAttributes) {
  const TestDirectory directory;
  const std::string path = directory.path("a.exr");
  const Image image = gradient({13, 7});
  write_exr(path, image, {{"manifest", "{\"seed\": 1}"}, {"a longer name than thirty-one characters", "x"}});
  std::map<std::string, std::string> attributes;
  const Image read = read_exr(path, &attributes);
  ASSERT_EQ(read.size, image.size);
  for (std::size_t i = 0; i < image.pixels.size(); ++i)
    for (int c = 0; c < 3; ++c) EXPECT_EQ(read.pixels[i][c], static_cast<double>(static_cast<float>(image.pixels[i][c])));
  EXPECT_EQ(attributes.at("manifest"), "{\"seed\": 1}");
  EXPECT_EQ(attributes.at("a longer name than thirty-one characters"), "x");
  EXPECT_EQ(directory.file_count(), 1u) << "no unfinished file is left";
}

TEST(Exr, SpecialValuesSurvive) {
  const TestDirectory directory;
  Image image({2, 1});
  image.at(0, 0) = {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), 0};
  write_exr(directory.path("a.exr"), image);
  const Image read = read_exr(directory.path("a.exr"));
  EXPECT_TRUE(std::isnan(read.at(0, 0).x));
  EXPECT_TRUE(std::isinf(read.at(0, 0).y));
}

TEST(Exr, OtherPixelTypesAreConverted) {
  const TestDirectory directory;
  const auto read = [&](const std::vector<Channel>& channels, ivec2 origin) {
    return read_exr(directory.write("a.exr", plain_exr(channels, origin, {3, 2})));
  };
  const auto H = PixelType::half, F = PixelType::single, U = PixelType::uint;
  EXPECT_EQ(read({{"B", H}, {"G", H}, {"R", H}}, {0, 0}).at(2, 1), dvec3(0.5, 0.5, 1));
  EXPECT_EQ(read({{"A", H}, {"B", F}, {"G", U}, {"R", H}, {"Z", F}}, {0, 0}).at(1, 0), dvec3(0.5, 2, 0.5));
  EXPECT_EQ(read({{"Y", H}}, {0, 0}).at(2, 1), dvec3(1, 1, 1));
  EXPECT_EQ(read({{"B", F}, {"G", F}, {"R", F}}, {-5, 100}).at(0, 1), dvec3(0.5, 0.5, 1)) << "a window that is off the origin";
}

// The matrix from Rec. 2020 has 1.6605 -0.5876 -0.0728, -0.1246 1.1329 -0.0083 and -0.0182 -0.1006 1.1187 as its rows.
TEST(Exr, ColoursOfOtherPrimariesBecomeSrgb) {
  const auto read = [](const std::vector<std::string>& names, const std::vector<float>& chromaticities) {
    std::vector<Channel> channels;
    for (const std::string& name : names) channels.push_back({name, PixelType::single});
    return parse_exr(plain_exr(channels, {0, 0}, {1, 1}, chromaticities), "a.exr").at(0, 0);
  };
  const auto expect_colour = [](const dvec3& a, const dvec3& b) {
    EXPECT_LT(glm::length(a - b), 1e-3) << a.x << ' ' << a.y << ' ' << a.z;
  };
  const std::vector<std::string> rgb{"B", "G", "R"};  // 1, 0.5, 0.5
  const std::vector<float> rec709{0.64f, 0.33f, 0.3f, 0.6f, 0.15f, 0.06f, 0.3127f, 0.329f},
      rec2020{0.708f, 0.292f, 0.17f, 0.797f, 0.131f, 0.046f, 0.3127f, 0.329f};
  EXPECT_EQ(read(rgb, rec709), dvec3(0.5, 0.5, 1)) << "to the bit";
  expect_colour(read(rgb, rec2020), {0.4637, 0.4959, 1.0593});
  EXPECT_EQ(read({"Y"}, rec2020), dvec3(1));
  const std::vector<Channel> channels{{"B", PixelType::single}, {"G", PixelType::single}, {"R", PixelType::single}};
  EXPECT_TRUE(decode_image(plain_exr(channels, {0, 0}, {1, 1}, rec2020), "a.exr").had_own_primaries);
  EXPECT_FALSE(decode_image(plain_exr(channels, {0, 0}, {1, 1}, rec709), "a.exr").had_own_primaries);
  expect_colour(read({"X", "Y", "Z"}, {}), {2.2226, -0.0105, 0.4823});
  EXPECT_ERROR(read(rgb, std::vector<float>(8, 0.0f)), "hromaticities");
}

TEST(Exr, UnfitFilesAreErrors) {
  const TestDirectory directory;
  EXPECT_ERROR(read_exr(directory.path("absent.exr")), "absent.exr");
  EXPECT_ERROR(read_exr(directory.path("")), "cannot read");
  EXPECT_ERROR(read_exr(directory.write("text.exr", "not an image")), "text.exr");
  EXPECT_ERROR(read_exr(directory.write("z.exr", plain_exr({{"Z", PixelType::single}}, {0, 0}, {3, 2}))),
               "expected channels R, G and B, or Y; found Z");
  EXPECT_ERROR(read_exr(directory.write("s.exr", plain_exr({{"Y", PixelType::half, 2}}, {0, 0}, {2, 2}))), "subsampled");
  EXPECT_ERROR(write_exr(directory.path("no/such/directory.exr"), gradient({2, 2})), "directory.exr: no directory");
  std::filesystem::create_directory(directory.path("taken.exr"));
  EXPECT_ERROR(write_exr(directory.path("taken.exr"), gradient({2, 2})), "taken.exr: exists and is not a regular file");
}

TEST(Exr, HugeWindowIsRefusedBeforeAllocation) {
  const TestDirectory directory;
  const std::string good = plain_exr({{"Y", PixelType::half}}, {0, 0}, {3, 2});
  const auto with_corner = [&](std::int32_t x, std::int32_t y) {
    std::string file = good;
    file.replace(good.find("dataWindow") + 10 + 1 + 6 + 4 + 8, 8, raw(x) + raw(y));
    return directory.write("a.exr", file);
  };
  EXPECT_ERROR(read_exr(with_corner(60000, 1)), "announces 60001 x 2 pixels");
  EXPECT_ERROR(read_exr(with_corner(2, 2000000000)), "cannot read");
}

TEST(Exr, DamagedFilesNeitherCrashNorHang) {
  const TestDirectory directory;
  const auto read = [&](const std::string& bytes) { read_exr(directory.write("a.exr", bytes)); };
  write_exr(directory.path("good.exr"), gradient({9, 5}), {{"note", "x"}});
  damage(slurp(directory.path("good.exr")), 500, read);
  damage(plain_exr({{"B", PixelType::half}, {"G", PixelType::single}, {"R", PixelType::uint}}, {0, 0}, {3, 2}), 500, read);
}

TEST(ImageFile, PngRoundTripDecodesSrgb) {
  const TestDirectory directory;
  const std::uint8_t rgb[] = {0, 10, 188, 255, 128, 1, 7, 8, 9, 200, 100, 50, 1, 2, 3, 4, 5, 6};
  const auto png = encode_png(rgb, {3, 2});
  const std::string path = directory.write("a.png", std::string(png.begin(), png.end()));
  const RgbImage linear = read_image(path, Encoding::linear), srgb = read_image(path);
  ASSERT_EQ(linear.size, ivec2(3, 2));
  for (std::size_t i = 0; i < 18; ++i)
    EXPECT_FLOAT_EQ(linear.texels[i / 3][static_cast<int>(i % 3)], static_cast<float>(rgb[i]) / 255);
  EXPECT_EQ(srgb.texels[0].x, 0);
  EXPECT_NEAR(srgb.texels[0].y, 10 / 255.0 / 12.92, 1e-7);
  EXPECT_NEAR(srgb.texels[0].z, 0.5028865, 1e-6);
  EXPECT_EQ(srgb.texels[1].x, 1);
}

TEST(ImageFile, TgaAndExrAndHdrAreRead) {
  const TestDirectory directory;
  std::string tga(18, '\0');
  tga[2] = 2, tga[12] = 1, tga[14] = 1, tga[16] = 24, tga[17] = 0x20;
  EXPECT_EQ(read_image(directory.write("a.tga", tga + "\xff" + std::string(2, '\0'))).texels.at(0), Rgb(0, 0, 1))
      << "blue comes first";
  const std::string hdr = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n";
  const RgbImage radiance = read_image(directory.write("a.hdr", hdr + std::string("\x80\x40\x20\x84\x80\x00\x00\x80", 8)));
  EXPECT_EQ(radiance.texels.at(0), Rgb(8, 4, 2));
  // Eight pixels in runs: red 1..8, green 16 throughout, blue 0, exponent that makes the unit 1/2.
  const std::string runs = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\nEXPOSURE=2\n\n-Y 1 +X 8\n" +
                           std::string("\x02\x02\x00\x08\x08\x01\x02\x03\x04\x05\x06\x07\x08\x88\x10\x88\x00\x88\x87", 19);
  EXPECT_EQ(read_image(directory.write("b.hdr", runs)).texels.at(6), Rgb(3.5f, 8, 0));
  EXPECT_ERROR(read_image(directory.write("b.hdr", runs.substr(0, runs.size() - 1))), "the file ends before its data does");
  EXPECT_ERROR(read_image(directory.write("b.hdr", "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 9000 +X 9000\nxxxx")),
               "announces 9000 x 9000");
  damage(runs, 1000, [&](const std::string& bytes) { read_image(directory.write("b.hdr", bytes)); });
  Image image({2, 1});
  image.at(1, 0) = {1, 2, std::numeric_limits<double>::quiet_NaN()};
  write_exr(directory.path("a.exr"), image);
  EXPECT_EQ(read_image(directory.path("a.exr")).texels.at(1), Rgb(1, 2, 0)) << "NaN becomes 0";
}

TEST(ImageFile, UnfitFilesAreErrors) {
  const TestDirectory directory;
  EXPECT_ERROR(read_image(directory.path("absent.png")), "absent.png");
  EXPECT_ERROR(read_image(directory.write("a.png", "hello, this is no image at all")),
               "neither PNG, JPEG, TGA, BMP, HDR, PFM nor EXR");
  const std::uint8_t rgb[12] = {};
  const auto png = encode_png(rgb, {2, 2});
  std::string huge(png.begin(), png.end());
  huge.replace(16, 8, std::string("\x00\x00\x20\x00\x00\x00\x20\x00", 8));
  EXPECT_ERROR(read_image(directory.write("huge.png", huge)), "announces 8192 x 8192 pixels");
  damage(std::string(png.begin(), png.end()), 500,
         [&](const std::string& bytes) { read_image(directory.write("b.png", bytes)); });
}

TEST(Octahedral, MapAndInverseAgree) {
  for (int y = 0; y < 16; ++y)
    for (int x = 0; x < 16; ++x) {
      const vec2 p((static_cast<float>(x) + 0.5f) / 16, (static_cast<float>(y) + 0.25f) / 16);
      const vec3 direction = octahedral_to_direction(p);
      EXPECT_NEAR(glm::length(direction), 1, 1e-6);
      const vec2 back = direction_to_octahedral(direction);
      EXPECT_NEAR(back.x, p.x, 1e-5);
      EXPECT_NEAR(back.y, p.y, 1e-5);
    }
  EXPECT_NEAR(octahedral_to_direction({0.5f, 0.5f}).z, 1, 1e-6) << "the middle is +z";
  EXPECT_NEAR(octahedral_to_direction({0.999999f, 0.5f}).x, 1, 1e-3);
}

TEST(Octahedral, MapKeepsAreas) {
  // Means over the square are means over the sphere: <z> = 0, <z^2> = <x^2> = 1/3.
  dvec3 squares(0);
  double z = 0;
  constexpr int n = 256;
  for (int y = 0; y < n; ++y)
    for (int x = 0; x < n; ++x) {
      const dvec3 d(octahedral_to_direction({(static_cast<float>(x) + 0.5f) / n, (static_cast<float>(y) + 0.5f) / n}));
      squares += d * d;
      z += d.z;
    }
  EXPECT_NEAR(z / (n * n), 0, 1e-6);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(squares[c] / (n * n), 1.0 / 3, 1e-4);
}

TEST(Octahedral, EquirectangularImageKeepsTheLightOfThePole) {
  constexpr int n = 32;
  RgbImage square{{n, n}, std::vector<Rgb>(n * n)};
  square.texels[(n / 2) * n + n / 2] = Rgb(1);
  const RgbImage image = octahedral_to_equirectangular(square);
  double light = 0;
  for (int y = 0; y < n; ++y)
    for (int x = 0; x < 2 * n; ++x)
      light += (std::cos(pi * y / n) - std::cos(pi * (y + 1) / n)) * (pi / n) *
               image.texels[static_cast<std::size_t>(y) * 2 * n + static_cast<std::size_t>(x)].x;
  EXPECT_NEAR(light / (4 * pi / (n * n)), 1, 0.02) << "8.7 % too much where all points of a texel count alike";
}

TEST(Octahedral, EquirectangularImageShowsTheSameSky) {
  // Radiance 1 + z + x / 2 + y / 4, linear in the direction.
  constexpr int n = 64;
  RgbImage square{{n, n}, {}};
  for (int y = 0; y < n; ++y)
    for (int x = 0; x < n; ++x) {
      const vec3 d = octahedral_to_direction({(static_cast<float>(x) + 0.5f) / n, (static_cast<float>(y) + 0.5f) / n});
      square.texels.emplace_back(1 + d.z + 0.5f * d.x + 0.25f * d.y);
    }
  const RgbImage image = octahedral_to_equirectangular(square);
  ASSERT_EQ(image.size, ivec2(2 * n, n));
  for (int y = 0; y < n; ++y)
    for (int x = 0; x < 2 * n; ++x) {
      const float phi = 2 * pi * (static_cast<float>(x) + 0.5f) / (2 * n), theta = pi * (static_cast<float>(y) + 0.5f) / n;
      const float expected = 1 + std::cos(theta) + std::sin(theta) * (0.5f * std::cos(phi) + 0.25f * std::sin(phi));
      EXPECT_NEAR(image.texels[static_cast<std::size_t>(y) * 2 * n + static_cast<std::size_t>(x)].x, expected, 0.02f);
    }
}

}  // namespace
}  // namespace etendue
