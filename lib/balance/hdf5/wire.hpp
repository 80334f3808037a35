#pragma once
/// Messages between two processes that do not trust each other.

#include <cstddef>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <string>

namespace balance {

/// The other end is gone, or says what makes no sense.
struct ChannelError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Numbers and texts one behind the other; taken out in the order in which they were put in.
class Message {
 public:
  Message() = default;
  explicit Message(std::string bytes) : bytes_(std::move(bytes)) {}

  void write(std::uint64_t number);
  void write(const std::string& text);
  /// @throws ChannelError if there is no more
  std::uint64_t read_number();
  std::string read_text();

  bool is_at_end() const { return at_ == bytes_.size(); }
  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
  std::size_t at_ = 0;
};

/// One end of a connected socket, which somebody else closes.
class MessageChannel {
 public:
  explicit MessageChannel(int socket) : socket_(socket) {}

  void send(const Message& message) const;
  /// @param most bytes. @throws ChannelError if the message is longer or does not come
  Message receive(std::size_t most) const;

  void send(std::span<const double> values) const;
  void receive(std::span<double> values) const;

 private:
  void send_bytes(const void* from, std::size_t count) const;
  void receive_bytes(void* to, std::size_t count) const;

  int socket_;
};

}  // namespace balance
