#include "peer/background_file.h"

namespace padr::peer {

BackgroundFile::BackgroundFile(std::string_view flag, const std::string& path, std::chrono::milliseconds interval,
                               std::size_t most)
    : file_(flag, path, shell::Readers::kAsUsual, shell::Content::kBinary),
      interval_(interval),
      room_(most),
      thread_([this] { write_on(); }) {}

BackgroundFile::~BackgroundFile() {
  end_thread();
}

bool BackgroundFile::append(std::span<const std::byte> bytes) {
  const std::lock_guard lock(mutex_);
  if (failed_ || bytes.size() > room_) return false;
  room_ -= bytes.size();
  waiting_.insert(waiting_.end(), bytes.begin(), bytes.end());
  return true;
}

bool BackgroundFile::has_failed() {
  const std::lock_guard lock(mutex_);
  return failed_;
}

void BackgroundFile::end_thread() {
  {
    const std::lock_guard lock(mutex_);
    closing_ = true;
  }
  wake_.notify_one();
  if (thread_.joinable()) thread_.join();
}

void BackgroundFile::close() {
  end_thread();
  if (trouble_) std::rethrow_exception(trouble_);
  file_.close();
}

void BackgroundFile::write_on() {
  std::vector<std::byte> writing;
  for (bool last = false; !last;) {
    {
      std::unique_lock lock(mutex_);
      wake_.wait_for(lock, interval_, [this] { return closing_; });
      last = closing_;
      writing.swap(waiting_);
    }
    try {
      if (!trouble_ && !writing.empty()) {
        file_.write(writing);
        file_.flush();
      }
    } catch (const std::exception&) {
      trouble_ = std::current_exception();  // read once the thread has ended
    }
    const std::lock_guard lock(mutex_);
    failed_ = trouble_ != nullptr;
    room_ += writing.size();
    writing.clear();
  }
}

}  // namespace padr::peer
