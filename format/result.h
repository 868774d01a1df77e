// A value or the reason there is none. Bad input is a Result; our own bugs are asserts.
#pragma once

#include <string>
#include <utility>
#include <variant>

namespace rro {

/// The exit code that an error becomes, if it reaches main.
enum class ErrorKind {
    Failed = 1,    // the work failed: not converged, out of memory, disk full
    Usage = 2,     // wrong command line
    BadInput = 3,  // a file or value that cannot be used
    Internal = 4,
};

/// One error, as a person reads it: "where: message" and, on a second line, the way out.
struct Error {
    ErrorKind kind = ErrorKind::BadInput;
    std::string where;    // file, then place: "room.json: /instances/3/archive"; may be empty
    std::string message;  // what was found, what was expected
    std::string hint;     // may be empty
};

/// An error of kind BadInput.
inline Error bad_input(std::string where, std::string message, std::string hint = {}) {
    return {ErrorKind::BadInput, std::move(where), std::move(message), std::move(hint)};
}
/// An error of kind Failed.
inline Error failed(std::string where, std::string message, std::string hint = {}) {
    return {ErrorKind::Failed, std::move(where), std::move(message), std::move(hint)};
}

/// A T, or an Error. Test it before use: `if (!result) return result.error();`
template <class T>
class [[nodiscard]] Result {
  public:
    Result(T value) : content_(std::move(value)) {}
    Result(Error error) : content_(std::move(error)) {}

    explicit operator bool() const { return content_.index() == 0; }
    T& operator*() & { return std::get<0>(content_); }
    const T& operator*() const& { return std::get<0>(content_); }
    T&& operator*() && { return std::get<0>(std::move(content_)); }
    T* operator->() { return &std::get<0>(content_); }
    const T* operator->() const { return &std::get<0>(content_); }
    const Error& error() const { return std::get<1>(content_); }

  private:
    std::variant<T, Error> content_;
};

/// For calls that give nothing but may fail.
struct Done {};
using Status = Result<Done>;

}  // namespace rro
