#include "experiments/command/preview.h"

#include "experiments/config/budget.h"
#include "framework/core/error.h"

#include <fmt/format.h>
#include <netdb.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <vector>

namespace etendue {

namespace {

static_assert(std::endian::native == std::endian::little, "the protocol's numbers are little-endian");

// A message, of which the length comes last, in front.
class Message {
 public:
  explicit Message(std::uint8_t type) {
    put(std::uint32_t{0});
    put(type);
    put(std::uint8_t{0});  // the viewer's focus is left where it is
  }
  template <class Number>
  void put(Number number) {
    bytes_.append(reinterpret_cast<const char*>(&number), sizeof number);
  }
  void put_text(std::string_view text) { bytes_.append(text).push_back('\0'); }
  void put_floats(const std::vector<float>& floats) {
    bytes_.append(reinterpret_cast<const char*>(floats.data()), floats.size() * sizeof(float));
  }
  const std::string& finish() {
    const auto length = static_cast<std::uint32_t>(bytes_.size());
    std::memcpy(bytes_.data(), &length, sizeof length);
    return bytes_;
  }

 private:
  std::string bytes_;
};

constexpr std::uint8_t create_image = 4, update_image = 6;

void put_channels(Message& message) {
  message.put(std::int32_t{3});
  for (const char* channel : {"R", "G", "B"}) message.put_text(channel);
}

// A connected socket, or -1 and the reason.
int connect_to(const std::string& host, const std::string& port, std::string& reason) {
  addrinfo hints{}, *found = nullptr;
  hints.ai_socktype = SOCK_STREAM;
  if (const int status = getaddrinfo(host.c_str(), port.c_str(), &hints, &found); status != 0) {
    reason = gai_strerror(status);
    return -1;
  }
  int connected = -1;
  for (const addrinfo* one = found; one && connected < 0; one = one->ai_next) {
    connected = socket(one->ai_family, one->ai_socktype | SOCK_CLOEXEC, one->ai_protocol);
    if (connected < 0) continue;
    const timeval patience{5, 0};  // with a viewer that hangs; it holds for connecting as well
    setsockopt(connected, SOL_SOCKET, SO_SNDTIMEO, &patience, sizeof patience);
    if (connect(connected, one->ai_addr, one->ai_addrlen) == 0) break;
    reason = std::strerror(errno);
    close(connected);
    connected = -1;
  }
  freeaddrinfo(found);
  return connected;
}

}  // namespace

Preview::Preview(const std::string& address, const std::string& name, ivec2 resolution) : address_(address), name_(name) {
  const std::size_t colon = address.rfind(':');
  const Location where{"--preview"};
  if (colon == std::string::npos || colon == 0 || colon + 1 == address.size())
    throw Error(where, fmt::format("'{}'; expected HOST:PORT, such as 127.0.0.1:14158", address));
  std::string reason;
  socket_ = connect_to(address.substr(0, colon), address.substr(colon + 1), reason);
  if (socket_ < 0)
    throw Error(where,
                fmt::format("{}: {}; expected tev to listen there (its own address is 127.0.0.1:14158)", address, reason));
  Message message(create_image);
  message.put_text(name_);
  message.put(std::int32_t{resolution.x});
  message.put(std::int32_t{resolution.y});
  put_channels(message);
  send_all(message.finish());
}

Preview::~Preview() {
  if (socket_ >= 0) close(socket_);
}

void Preview::send_all(std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t sent = send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (sent < 0 && errno == EINTR) continue;
    if (sent <= 0) {
      failure_ = fmt::format("the viewer at {} did not take the image: {}", address_, std::strerror(errno));
      close(socket_);
      socket_ = -1;
      return;
    }
    bytes.remove_prefix(static_cast<std::size_t>(sent));
  }
}

void Preview::update(const std::function<Image()>& image) {
  if (socket_ < 0 || now_s() < next_s_) return;
  const double took = seconds_of([&] { send_image(image()); });
  next_s_ = now_s() + 20 * took;
}

void Preview::finish(const Image& image) {
  if (socket_ >= 0) send_image(image);
}

void Preview::send_image(const Image& image) {
  // Bands of rows, since a message has less than 4 GiB; each pixel's channels lie together.
  constexpr int rows_at_once = 256;
  for (int top = 0; top < image.size.y && socket_ >= 0; top += rows_at_once) {
    const int rows = std::min(rows_at_once, image.size.y - top);
    Message message(update_image);
    message.put_text(name_);
    put_channels(message);
    for (const std::int32_t number : {0, top, image.size.x, rows}) message.put(number);
    for (const std::int64_t offset : {0, 1, 2}) message.put(offset);
    for (const std::int64_t stride : {3, 3, 3}) message.put(stride);
    std::vector<float> floats;
    for (int y = top; y < top + rows; ++y)
      for (int x = 0; x < image.size.x; ++x)
        for (int channel = 0; channel < 3; ++channel) floats.push_back(static_cast<float>(image.at(x, y)[channel]));
    message.put_floats(floats);
    send_all(message.finish());
  }
}

}  // namespace etendue
