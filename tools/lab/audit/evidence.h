#pragma once

#include <cstddef>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "common/trace/events.h"
#include "tools/lab/audit/hash_record.h"
#include "tools/lab/audit/ledger.h"
#include "tools/lab/audit/members.h"

namespace padr::lab::audit {

/// A trace file's content; `label` is for messages.
struct TraceText {
  std::string label;
  std::span<const std::byte> bytes;
};

/// What one trace says besides what its members said.
struct TraceFacts {
  trace::Header header;
  MemberId owner = 0;
  Tick last = 0;                                 ///< tick of its last step
  bool plays_alone = false;                      ///< its owner plays bodies that nobody owns by itself, or once did
  std::map<EntityId, std::vector<Tick>> pushes;  ///< by body: when its owner pushed it
  HashRecord hashes;
};

/// All that is read from the traces before any is played again.
struct Evidence {
  explicit Evidence(std::size_t count) : members(count), traces(count) {}
  Members members;
  Ledger ledger;
  std::vector<TraceFacts> traces;

  /// The traces' session id; all zeros: the session has no key, or no trace tells it.
  SessionId session() const;
  /// Whether an update bears its author's signature.
  bool is_signed(MemberId author, const sync::Bundle& update) const;
  /// Whether the author's own trace is among the traces and reaches that tick.
  const TraceFacts* own_trace(MemberId author, Tick tick) const;
};

/// Reads the traces of one session. Throws UserError if a trace is damaged, or they are of several sessions.
Evidence read_evidence(const std::vector<TraceText>& traces, const Scene& scene);

}  // namespace padr::lab::audit
