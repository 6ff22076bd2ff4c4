// A render as it grows, shown in the image viewer tev (https://github.com/Tom94/tev) over its network protocol: messages of a
// length in bytes (its own four included), a type, and fields, little-endian, text ended by a zero. Two types serve: 4 creates
// an image, 6 updates a rectangle of several channels.
#pragma once

#include "framework/image/film.h"

#include <functional>
#include <string>
#include <string_view>

namespace etendue {

class Preview {
 public:
  // Connects and creates an image of that name. `address` is "host:port". Throws Error where nobody answers there.
  Preview(const std::string& address, const std::string& name, ivec2 resolution);
  ~Preview();
  Preview(const Preview&) = delete;
  Preview& operator=(const Preview&) = delete;

  // Sends the image so far, but so seldom that sending takes a twentieth of the time. A viewer that no longer takes it is left
  // alone from then on.
  void update(const std::function<Image()>& image);
  void finish(const Image& image);                         // in any case
  const std::string& failure() const { return failure_; }  // why the viewer did not get all of it; "": it did

 private:
  void send_image(const Image& image);
  void send_all(std::string_view bytes);

  std::string address_, name_, failure_;
  int socket_ = -1;
  double next_s_ = 0;
};

}  // namespace etendue
