// A render shown in tev: a listener in its place takes the messages apart.
#include "framework/io/image/exr.h"
#include "tests/unit/harness_process.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <cstring>

namespace etendue {
namespace {

class PreviewTest : public ProgramTest {
 protected:
  void SetUp() override {
    ProgramTest::SetUp();
    listener_ = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t length = sizeof address;
    ASSERT_EQ(bind(listener_, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
    ASSERT_EQ(listen(listener_, 1), 0);
    ASSERT_EQ(getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &length), 0);
    address_ = "127.0.0.1:" + std::to_string(ntohs(address.sin_port));
  }
  void TearDown() override {
    close(listener_);
    ProgramTest::TearDown();
  }
  std::vector<std::string> command(const std::string& spp) {
    return {"render", "builtin:cornell-box", "--resolution", "20x300", "--spp", spp, "--threads", "1", "-o",
            "a.exr",  "--preview",           address_};
  }

  int listener_ = -1;
  std::string address_;
};

// Reads a message's fields in order.
struct Fields {
  std::string bytes;
  std::size_t at = 0;
  template <class Number>
  Number next() {
    Number number{};
    std::memcpy(&number, bytes.data() + at, sizeof number);
    at += sizeof number;
    return number;
  }
  std::string text() {
    const std::string found = bytes.c_str() + at;
    at += found.size() + 1;
    return found;
  }
};

TEST_F(PreviewTest, SendsTheImageAsItWasWritten) {
  const pid_t pid = start(command("3"));
  const int connection = accept(listener_, nullptr, nullptr);
  std::string all;
  char buffer[65536];
  for (ssize_t got; (got = read(connection, buffer, sizeof buffer)) > 0;) all.append(buffer, static_cast<std::size_t>(got));
  close(connection);
  const Outcome outcome = finish(pid);
  EXPECT_EQ(outcome.status, 0) << outcome.err;

  Fields fields{all};
  EXPECT_EQ(fields.next<std::uint32_t>(), 4u + 1 + 1 + 6 + 12 + 6);
  EXPECT_EQ(fields.next<std::uint8_t>(), 4);
  EXPECT_EQ(fields.next<std::uint8_t>(), 0);
  EXPECT_EQ(fields.text(), "a.exr");
  EXPECT_EQ(fields.next<std::int32_t>(), 20);
  EXPECT_EQ(fields.next<std::int32_t>(), 300);
  EXPECT_EQ(fields.next<std::int32_t>(), 3);
  for (const char* channel : {"R", "G", "B"}) EXPECT_EQ(fields.text(), channel);

  std::vector<float> received(3 * 20 * 300, -1);
  int updates = 0;
  for (; fields.at < all.size(); ++updates) {
    const std::size_t begin = fields.at, length = fields.next<std::uint32_t>();
    ASSERT_LE(begin + length, all.size());
    EXPECT_EQ(fields.next<std::uint8_t>(), 6);
    fields.next<std::uint8_t>();
    EXPECT_EQ(fields.text(), "a.exr");
    EXPECT_EQ(fields.next<std::int32_t>(), 3);
    for (const char* channel : {"R", "G", "B"}) EXPECT_EQ(fields.text(), channel);
    EXPECT_EQ(fields.next<std::int32_t>(), 0);
    const auto y = fields.next<std::int32_t>();
    EXPECT_EQ(fields.next<std::int32_t>(), 20);
    const auto rows = fields.next<std::int32_t>();
    for (const std::int64_t number : {0, 1, 2, 3, 3, 3}) EXPECT_EQ(fields.next<std::int64_t>(), number);
    ASSERT_EQ(fields.at + static_cast<std::size_t>(rows) * 20 * 3 * sizeof(float), begin + length);
    std::memcpy(&received[static_cast<std::size_t>(y) * 20 * 3], all.data() + fields.at, begin + length - fields.at);
    fields.at = begin + length;
  }
  EXPECT_GE(updates, 4);  // of two bands each: one while it rendered, and the end
  const Image image = read_exr((directory_ / "a.exr").string());
  for (std::size_t i = 0; i < image.pixels.size(); ++i)
    for (int channel = 0; channel < 3; ++channel)
      ASSERT_EQ(received[3 * i + static_cast<std::size_t>(channel)], static_cast<float>(image.pixels[i][channel]));
}

TEST_F(PreviewTest, AViewerThatLeavesStopsNoRender) {
  const pid_t pid = start(command("30"));
  close(accept(listener_, nullptr, nullptr));
  const Outcome outcome = finish(pid);
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_NE(outcome.err.find("did not take the image"), std::string::npos) << outcome.err;
}

TEST_F(PreviewTest, AViewerThatIsNotThereIsAnError) {
  close(listener_);
  const Outcome refused = run(command("1"));
  EXPECT_EQ(refused.status, 2);
  EXPECT_NE(refused.err.find("--preview: " + address_ + ": Connection refused; expected tev"), std::string::npos)
      << refused.err;
  const Outcome wrong = run({"render", "builtin:furnace", "--preview", "localhost"});
  EXPECT_NE(wrong.err.find("expected HOST:PORT"), std::string::npos) << wrong.err;
}

}  // namespace
}  // namespace etendue
