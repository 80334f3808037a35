#include "balance/hdf5/wire.hpp"

#include <sys/socket.h>

#include <cerrno>
#include <cstring>

namespace balance {

void Message::write(std::uint64_t number) {
  char bytes[sizeof number];
  std::memcpy(bytes, &number, sizeof number);
  bytes_.append(bytes, sizeof number);
}

void Message::write(const std::string& text) {
  write(std::uint64_t{text.size()});
  bytes_ += text;
}

std::uint64_t Message::read_number() {
  std::uint64_t number = 0;
  if (bytes_.size() - at_ < sizeof number) throw ChannelError("a message is too short");
  std::memcpy(&number, bytes_.data() + at_, sizeof number);
  at_ += sizeof number;
  return number;
}

std::string Message::read_text() {
  const std::uint64_t length = read_number();
  if (bytes_.size() - at_ < length) throw ChannelError("a message is too short");
  at_ += length;
  return bytes_.substr(at_ - length, length);
}

void MessageChannel::send(const Message& message) const {
  const std::uint64_t length = message.bytes().size();
  send_bytes(&length, sizeof length);
  send_bytes(message.bytes().data(), message.bytes().size());
}

Message MessageChannel::receive(std::size_t most) const {
  std::uint64_t length = 0;
  receive_bytes(&length, sizeof length);
  if (length > most) throw ChannelError("a message is too long");
  std::string bytes(length, '\0');
  receive_bytes(bytes.data(), bytes.size());
  return Message(std::move(bytes));
}

void MessageChannel::send(std::span<const double> values) const { send_bytes(values.data(), values.size_bytes()); }

void MessageChannel::receive(std::span<double> values) const { receive_bytes(values.data(), values.size_bytes()); }

void MessageChannel::send_bytes(const void* from, std::size_t count) const {
  for (std::size_t done = 0; done < count;) {
    const ssize_t now = ::send(socket_, static_cast<const char*>(from) + done, count - done, MSG_NOSIGNAL);
    if (now < 0 && errno == EINTR) continue;
    if (now <= 0) throw ChannelError("nobody listens");
    done += static_cast<std::size_t>(now);
  }
}

void MessageChannel::receive_bytes(void* to, std::size_t count) const {
  for (std::size_t done = 0; done < count;) {
    const ssize_t now = ::recv(socket_, static_cast<char*>(to) + done, count - done, 0);
    if (now < 0 && errno == EINTR) continue;
    if (now <= 0) throw ChannelError("nobody speaks");
    done += static_cast<std::size_t>(now);
  }
}

}  // namespace balance
