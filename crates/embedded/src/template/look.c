    @prefix@_sensors all;
    @prefix@_inputs used;
    const unsigned lost = look(state, in, &all, &used);
    if ((lost & @PREFIX@_FAILED) != 0u) {
        go_to_safe(state, &all, lost, out);
        return @PREFIX@_OK;
    }
    if (all.changed) {
        const int followed = follow(state, &used, state->put_out);
        if (followed != @PREFIX@_OK) return followed;
    }
    in = &used;
