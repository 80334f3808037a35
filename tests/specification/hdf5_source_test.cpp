// What a child process says of a file is checked like any stranger's words.

#include "balance/foundation/hdf5/hdf5_read_server.hpp"
#include "balance/foundation/hdf5/hdf5_reader.hpp"
#include "balance/foundation/hdf5/sandbox_process.hpp"

#include <doctest/doctest.h>

#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <thread>

using namespace balance;
using namespace balance::hdf5;

namespace {

const std::string table = std::string(BALANCE_TEST_DATA) + "/joints.h5";

/// Two connected sockets.
struct Sockets {
  std::array<int, 2> ends{};
  Sockets() { REQUIRE(::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) == 0); }
  ~Sockets() {
    for (const int end : ends) ::close(end);
  }
};

/// The answer to one question of a file, asked in this process.
Message answer_of(const std::string& file, const Message& question) {
  const Sockets sockets;
  std::thread server([&] {
    serve_requests(file, MessageChannel(sockets.ends[1]));
    ::shutdown(sockets.ends[1], SHUT_RDWR);
  });
  const MessageChannel wire(sockets.ends[0]);
  Message answer = wire.receive(1 << 20);
  if (answer.read_number() == 1) {
    wire.send(question);
    answer = wire.receive(1 << 20);
  }
  ::shutdown(sockets.ends[0], SHUT_RDWR);
  server.join();
  return answer;
}

}  // namespace

TEST_CASE("the child's answers are the library's (C2)") {
  CHECK(answer_of(table, make_read_request(Hdf5Request::has, "time")).bytes().size() == 2 * sizeof(std::uint64_t));
  Message answer = answer_of(table, make_read_request(Hdf5Request::numbers, "time"));
  CHECK(answer.read_number() == 1);
  CHECK(answer.read_number() == 1);
  CHECK(answer.read_number() > 1);
  CHECK(answer.is_at_end());
  Message complaint = answer_of(table, make_read_request(Hdf5Request::texts, "time", "", 10));
  CHECK(complaint.read_number() == 0);
  CHECK(complaint.read_text() == "'time': expected strings, found something else");
  for (const Hdf5Request kind : {Hdf5Request::text_attribute, Hdf5Request::numbers_attribute}) {
    Message none = answer_of(table, make_read_request(kind, "", "none", 10));
    CHECK(none.read_number() == 1);
    CHECK(none.read_number() == 0);
  }
  Message groups = answer_of(table, make_read_request(Hdf5Request::groups, "", "", 10));
  CHECK(groups.read_number() == 1);
  CHECK(groups.read_number() == 0);
  CHECK(answer_of(table + "x", make_read_request(Hdf5Request::has, "time")).is_at_end());
}

TEST_CASE("a file is read through a child as it is, and refused beyond the limits (C2)") {
  const Hdf5Reader source(table);
  CHECK(source.has("time"));
  CHECK_FALSE(source.has("none"));
  const auto time = source.numbers("time", 1);
  CHECK(time.sizes.size() == 1);
  CHECK(time.values.size() == time.sizes[0]);
  CHECK_THROWS_WITH_AS(source.numbers("time", 0), "'time': expected at most 0 dimensions, found 1", Hdf5Error);
  CHECK_THROWS_WITH_AS(source.numbers("time", 1, 1), "'time': expected at most 1 values, found more", Hdf5Error);
  CHECK(source.numbers("time", 1).values == time.values);  // a refusal spoils nothing
  CHECK_THROWS_AS(source.numbers("none"), Hdf5Error);
}

TEST_CASE("messages that are too short or too long are refused (C2)") {
  Message message;
  message.write(std::uint64_t{7});
  message.write(std::string("seven"));
  CHECK(message.read_number() == 7);
  CHECK(message.read_text() == "seven");
  CHECK(message.is_at_end());
  CHECK_THROWS_AS(message.read_number(), ChannelError);
  Message lying;
  lying.write(std::uint64_t{1} << 60);
  CHECK_THROWS_AS(lying.read_text(), ChannelError);

  const Sockets sockets;
  const MessageChannel here(sockets.ends[0]), there(sockets.ends[1]);
  here.send(message);
  CHECK_THROWS_AS(there.receive(message.bytes().size() - 1), ChannelError);

  const Sockets silent;
  ::shutdown(silent.ends[0], SHUT_RDWR);
  CHECK_THROWS_AS(MessageChannel(silent.ends[1]).receive(100), ChannelError);
  CHECK_THROWS_AS(MessageChannel(silent.ends[0]).send(message), ChannelError);
}
