#pragma once
/// Memory of the groups of a step, filled by gather_groups().
#include <vector>

#include "engine/base/disjoint_sets.hpp"
#include "engine/solvers/articulated/impulses/contact_groups.hpp"
#include "engine/world/report.hpp"

namespace pantin::detail::articulated {

/// Scratch memory of the groups of a step.
struct GroupScratch {
  /// One group: its bodies, dynamic ones first, its contacts, and so on.
  struct Range {
    std::size_t first_body = 0, bodies = 0, first_contact = 0, contacts = 0;
    std::size_t first_node = 0, nodes = 0, first_tree = 0, trees = 0, first_cross = 0, crosses = 0;
    std::size_t first_tie = 0, ties = 0, first_rolling = 0, rollings = 0;
    std::size_t first_loops = 0, loops = 0, first_looped = 0, looped = 0;
    std::size_t first_step = 0, steps = 0, first_number = 0, numbers = 0;
    std::size_t first_pair = 0, pairs = 0;
    std::size_t first_resting = 0, resting = 0, first_link = 0, links = 0;
    std::size_t first_column = 0, columns = 0, first_mark = 0, marks = 0;
    bool pressed = false, waits = false;
    std::size_t first_laned = 0, laned = 0, first_batch = 0, batches = 0, lane_numbers = 0;
  };
  DisjointSets sets{0};                 // of islands
  std::vector<std::uint32_t> group_of;  // by island
  std::vector<std::uint8_t> flags;      // by group, which is its first island
  std::vector<Real> speeds;             // m/s, the fastest of a group, likewise
  std::vector<Real> creeping;        // bodies of a heap that creep beyond those that may, likewise
  std::vector<std::uint64_t> keys;   // of contacts: group and number
  std::vector<std::uint32_t> order;  // of contacts
  std::vector<std::uint32_t> index;  // of a body in its group, by slot
  std::vector<Range> groups;
  std::vector<GroupBody> bodies;
  std::vector<GroupContact> contacts;
  std::vector<GroupPair> pairs;
  std::vector<LanedPair> laned;
  std::vector<PairBatch> batches;
  std::vector<std::uint64_t> colours;  // by body of a group: a bit for each
  std::vector<GroupNode> nodes;
  std::vector<GroupTree> trees;
  std::vector<CrossResponse> crosses;
  std::vector<GroupTie> ties;
  std::vector<GroupRolling> rollings;
  std::vector<TouchingSkins> skins;
  std::vector<GroupLoops> loops;
  std::vector<LoopedBody> looped;
  std::vector<PathStep> path_steps;
  std::vector<RestBody> resting;
  std::vector<RestContact> rest_contacts;  // as `contacts`
  std::vector<FactorRow> rest_rows;        // these three are a BlockPattern
  std::vector<std::uint32_t> rest_columns, rest_marks;
  std::vector<RestLink> rest_links;
  std::vector<Real> number_list;
  std::size_t numbers = 0;                     // of these, in use
  std::vector<Rest> rests;                     // by group
  std::vector<GroupCost> costs;                // by group, in a step with a budget
  std::vector<Real> weights;                   // see weigh_groups()
  Real cost = 0;                               // s, of a unit of weight in a substep
  std::vector<std::uint32_t> ends, roots;      // by column, while an island is gathered
  std::vector<std::uint32_t> links, numbered;  // see find_order()
  std::vector<std::uint64_t> fill;             // see find_elimination_order(), likewise `degrees`
  std::vector<std::uint32_t> degrees;
};

}  // namespace pantin::detail::articulated
