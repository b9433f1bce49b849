// Whether a row of the chunk has room among the rows out, of which `capacity` entries can be held.
bool row_fits(uint base, uint offset, uint length, uint capacity) {
    return base <= capacity && offset <= capacity - base && length <= capacity - base - offset;
}
