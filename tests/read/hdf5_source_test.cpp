// What a child process says of a file is checked like any stranger's words.

#include "balance/hdf5/server.hpp"
#include "balance/hdf5/source.hpp"
#include "balance/hdf5/wire.hpp"

#include <doctest/doctest.h>

#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <thread>

using namespace balance;

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
    answer_questions(file, Wire(sockets.ends[1]));
    ::shutdown(sockets.ends[1], SHUT_RDWR);
  });
  const Wire wire(sockets.ends[0]);
  Message answer = wire.receive(1 << 20);
  if (answer.take_number() == 1) {
    wire.send(question);
    answer = wire.receive(1 << 20);
  }
  ::shutdown(sockets.ends[0], SHUT_RDWR);
  server.join();
  return answer;
}

}  // namespace

TEST_CASE("the child's answers are the library's (C2)") {
  CHECK(answer_of(table, question_about(Hdf5Question::has, "time")).bytes().size() == 2 * sizeof(std::uint64_t));
  Message answer = answer_of(table, question_about(Hdf5Question::numbers, "time"));
  CHECK(answer.take_number() == 1);
  CHECK(answer.take_number() == 1);
  CHECK(answer.take_number() > 1);
  CHECK(answer.is_used_up());
  Message complaint = answer_of(table, question_about(Hdf5Question::texts, "time", "", 10));
  CHECK(complaint.take_number() == 0);
  CHECK(complaint.take_text() == "'time': expected texts, found something else");
  for (const Hdf5Question kind : {Hdf5Question::text_attribute, Hdf5Question::numbers_attribute}) {
    Message none = answer_of(table, question_about(kind, "", "none", 10));
    CHECK(none.take_number() == 1);
    CHECK(none.take_number() == 0);
  }
  Message groups = answer_of(table, question_about(Hdf5Question::groups, "", "", 10));
  CHECK(groups.take_number() == 1);
  CHECK(groups.take_number() == 0);
  CHECK(answer_of(table + "x", question_about(Hdf5Question::has, "time")).is_used_up());
}

TEST_CASE("a file is read through a child as it is, and refused beyond the limits (C2)") {
  const Hdf5Source source(table);
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
  message.put(std::uint64_t{7});
  message.put(std::string("seven"));
  CHECK(message.take_number() == 7);
  CHECK(message.take_text() == "seven");
  CHECK(message.is_used_up());
  CHECK_THROWS_AS(message.take_number(), WireBroken);
  Message lying;
  lying.put(std::uint64_t{1} << 60);
  CHECK_THROWS_AS(lying.take_text(), WireBroken);

  const Sockets sockets;
  const Wire here(sockets.ends[0]), there(sockets.ends[1]);
  here.send(message);
  CHECK_THROWS_AS(there.receive(message.bytes().size() - 1), WireBroken);

  const Sockets silent;
  ::shutdown(silent.ends[0], SHUT_RDWR);
  CHECK_THROWS_AS(Wire(silent.ends[1]).receive(100), WireBroken);
  CHECK_THROWS_AS(Wire(silent.ends[0]).send(message), WireBroken);
}
