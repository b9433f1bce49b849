#include "run/settle.hpp"

#include <utility>

#include "arguments/carried.hpp"
#include "picture.hpp"

namespace clvotess {

DomainFrom settle_domain(const Arguments& arguments, std::size_t dimensions, const FileDomain& stated,
                         votess::Options& options) {
    choose_dimensions(dimensions == 2, options);
    const DomainFrom from = choose_domain(stated, arguments.periodic, options, arguments.hull);
    if (options.cell && from.box == DomainSource::stated) check_edges(arguments.input, *options.cell);
    return from;
}

Settled settle(const Arguments& arguments, Input input) {
    Settled run{std::move(input), arguments.options, {}, {}};
    drop_upper_walls(arguments, run.input);
    complete_columns(arguments, run.input);
    take_weights(arguments, run.input, run.options);
    if (arguments.query.empty()) {
        run.carried = take_carried(arguments, run.input);
        arguments.coloring.check(run.carried, run.input.planar());
        if (arguments.picture) check_picture(*arguments.picture, run.input.planar());
    }
    run.domain_from = settle_domain(arguments, run.input.dimensions, run.input.domain, run.options);
    check_corner(run.input, run.options, run.domain_from);
    return run;
}

}  // namespace clvotess
