#pragma once
// A folder with pictures of proposals, named by their ids.
#include <filesystem>
#include <string>
#include <vector>

#include "server/pipeline/proposal_book.h"
#include "server/pipeline/views.h"

namespace meshloop {

class ProposalPictures {
 public:
  /// Makes the folder; an empty name: no pictures are written.
  [[nodiscard]] static Result<ProposalPictures> create(const std::filesystem::path& folder);

  [[nodiscard]] bool wanted() const { return !folder_.empty(); }
  /// The view over colour with one proposal framed: "proposal_0003.png" in the folder, which is returned.
  [[nodiscard]] Result<std::string> write(const TrackedFrame& tracked, const Examination& examination,
                                          const Offered& offered, Views& views) const;
  /// The same frame compared with the model that has it accepted: "proposal_0003_after.png". The frame stays where the
  /// region was in `before`.
  [[nodiscard]] Result<std::string> write_after(const TrackedFrame& tracked, const Examination& before,
                                                const Examination& after, const Offered& offered, Revision revision,
                                                Views& views) const;

 private:
  explicit ProposalPictures(std::filesystem::path folder) : folder_{std::move(folder)} {}
  std::filesystem::path folder_;
};

/// A frame's regions under the ids of the proposals that close them, for the journal's picture. A move is framed twice,
/// where it was and where it is, in place of its regions.
[[nodiscard]] Framing framing_of(const RegionMap& regions, const std::vector<Offered>& offered);

/// The pixels of what a proposal closes as one region that has its id. A proposal for the rest of a region, which no
/// region of the examination is, has the pixels of its kind whose regions reach into its box.
[[nodiscard]] RegionMap marked(const RegionMap& regions, const Proposal& proposal);

}  // namespace meshloop
