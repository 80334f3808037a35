#pragma once
/// Messages between two processes that do not trust each other.

#include <cstddef>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <string>

namespace balance {

/// The other end is gone, or says what makes no sense.
struct WireBroken : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Numbers and texts one behind the other; taken out in the order in which they were put in.
class Message {
 public:
  Message() = default;
  explicit Message(std::string bytes) : bytes_(std::move(bytes)) {}

  void put(std::uint64_t number);
  void put(const std::string& text);
  /// @throws WireBroken if there is no more
  std::uint64_t take_number();
  std::string take_text();

  bool is_used_up() const { return at_ == bytes_.size(); }
  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
  std::size_t at_ = 0;
};

/// One end of a connected socket, which somebody else closes.
class Wire {
 public:
  explicit Wire(int socket) : socket_(socket) {}

  void send(const Message& message) const;
  /// @param most bytes. @throws WireBroken if the message is longer or does not come
  Message receive(std::size_t most) const;

  void send(std::span<const double> values) const;
  void receive(std::span<double> values) const;

 private:
  void send_bytes(const void* from, std::size_t count) const;
  void receive_bytes(void* to, std::size_t count) const;

  int socket_;
};

}  // namespace balance
