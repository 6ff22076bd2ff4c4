// The operations of a <transform>, of which the first is applied first.

#include "framework/io/mitsuba/properties.h"
#include "framework/io/text.h"

#include <fmt/format.h>

#include <algorithm>

namespace etendue {

namespace {

// A word of "0.1, 0.2 0.3"; empty at the end.
std::string_view next_word(std::string_view& rest) {
  constexpr std::string_view between = " \t\r\n,";
  rest.remove_prefix(std::min(rest.find_first_not_of(between), rest.size()));
  const std::string_view word = rest.substr(0, rest.find_first_of(between));
  rest.remove_prefix(word.size());
  return word;
}

// What is missing has a default, and what is misspelt is not missing.
void expect_attributes(const XmlElement& element, std::initializer_list<std::string> known) {
  for (const XmlAttribute& attribute : element.attributes)
    if (std::ranges::find(known, attribute.name) == known.end())
      throw Error(element.where(attribute.name),
                  fmt::format("{}: {}", element.tag, unknown_name("attribute", attribute.name, std::vector(known))));
}

vec3 read_point(const XmlElement& element, std::string_view attribute, const vec3& otherwise) {
  if (!element.find(attribute)) return otherwise;
  const std::vector<float> n = read_numbers(element, attribute);
  if (n.size() != 3)
    throw Error(element.where(attribute), fmt::format("{}: expected three numbers, found {}", attribute, n.size()));
  return {n[0], n[1], n[2]};
}

Transform read_matrix(const XmlElement& element) {
  const std::vector<float> n = read_numbers(element, "value");
  if (n.size() != 16 && n.size() != 9)
    throw Error(element.where("value"), fmt::format("matrix: expected 16 numbers (or 9), row by row, found {}", n.size()));
  const int size = n.size() == 16 ? 4 : 3;
  mat4 m(1);
  for (int row = 0; row < size; ++row)
    for (int column = 0; column < size; ++column) m[column][row] = n[static_cast<std::size_t>(row * size + column)];
  for (int i = 0; i < 4; ++i) {
    const float affine = i < 3 ? 0 : 1;
    if (std::abs(m[i][3] - affine) > 1e-6f)
      throw Error(element.where("value"), "matrix: is not affine; expected 0 0 0 1 as its last row");
    m[i][3] = affine;
  }
  const auto transform = Transform::from_matrix(m);
  if (!transform) throw Error(element.where("value"), "matrix: has no inverse");
  return *transform;
}

Transform read_rotation(const XmlElement& element) {
  const vec3 axis = read_vector(element, vec3(0));
  const double length = glm::length(dvec3(axis));
  if (!(length > 0)) throw Error(element.where(), "rotate: expected an axis, such as y=\"1\"");
  return Transform::rotate(read_number(element, "angle") * (pi / 180), vec3(dvec3(axis) / length));
}

Transform read_scale(const XmlElement& element) {
  const vec3 factors = read_vector(element, vec3(1));
  for (int i = 0; i < 3; ++i)
    if (factors[i] == 0) throw Error(element.where(), "scale: a factor of 0 has no inverse");
  return Transform::scale(factors);
}

// Without an up it is that of Mitsuba 3: the first axis of [Duff2017]'s frame about the view.
Transform read_look_at(const XmlElement& element) {
  expect_attributes(element, {"origin", "target", "up"});
  const vec3 origin = read_point(element, "origin", vec3(0)), target = read_point(element, "target", vec3(0, 0, 1));
  vec3 up = read_point(element, "up", vec3(0));
  if (up == vec3(0) && target != origin) up = Frame::from_normal(glm::normalize(target - origin)).tangent;
  const auto transform = Transform::look_at(origin, target, up);
  if (!transform) throw Error(element.where(), "lookat: the origin is the target, or up points along the view");
  return *transform;
}

Transform read_operation(const XmlElement& element) {
  if (element.tag == "translate") return Transform::translate(read_vector(element, vec3(0)));
  if (element.tag == "scale") return read_scale(element);
  if (element.tag == "rotate") return read_rotation(element);
  if (element.tag == "lookat") return read_look_at(element);
  if (element.tag == "matrix") return read_matrix(element);
  throw Error(element.where(), unknown_name("transform", element.tag,
                                            std::vector<std::string>{"translate", "scale", "rotate", "lookat", "matrix"}));
}

}  // namespace

std::vector<float> read_numbers(const XmlElement& element, std::string_view attribute) {
  const XmlAttribute* found = element.find(attribute);
  if (!found) throw Error(element.where(), fmt::format("{}: '{}' is missing", element.tag, attribute));
  std::vector<float> numbers;
  std::string_view rest = found->value;
  for (std::string_view word = next_word(rest); !word.empty(); word = next_word(rest)) {
    const auto number = parse_number(word);
    if (!number)
      throw Error(element.where(attribute),
                  fmt::format("{}: {} is not a number that single precision holds", element.tag, quote(word)));
    numbers.push_back(static_cast<float>(*number));
  }
  return numbers;
}

float read_number(const XmlElement& element, std::string_view attribute) {
  const std::vector<float> numbers = read_numbers(element, attribute);
  if (numbers.size() != 1)
    throw Error(element.where(attribute), fmt::format("{}: expected one number, found {}", element.tag, numbers.size()));
  return numbers[0];
}

vec3 read_vector(const XmlElement& element, const vec3& otherwise) {
  expect_attributes(element, {"x", "y", "z", "value", "angle", "name", "id"});
  if (element.find("value")) {
    const std::vector<float> n = read_numbers(element, "value");
    if (n.size() == 1) return vec3(n[0]);
    if (n.size() != 3)
      throw Error(element.where("value"), fmt::format("{}: expected one number or three, found {}", element.tag, n.size()));
    return {n[0], n[1], n[2]};
  }
  vec3 v = otherwise;
  constexpr std::string_view axes[] = {"x", "y", "z"};
  for (int i = 0; i < 3; ++i)
    if (element.find(axes[i])) v[i] = read_number(element, axes[i]);
  return v;
}

Transform read_transform(const XmlElement& element) {
  Transform all;
  for (const XmlElement& child : element.children) all = read_operation(child) * all;
  const Transform inverse = all.inverse();
  for (const Transform& t : {all, inverse})
    if (!is_finite(t.point(vec3(0))) || !is_finite(t.vector(vec3(1))) || !is_finite(t.vector(vec3(1, -1, 0.5f))))
      throw Error(element.where(), "the transforms together leave the range of single precision");
  return all;
}

}  // namespace etendue
