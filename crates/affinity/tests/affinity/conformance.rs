//! Every affinity in `KINDS` does what the rest of the program relies on.

use crosscut_affinity::KINDS;
use crosscut_conformance::affinity;

macro_rules! every_kind {
    ($($test:ident)*) => {$(
        #[test]
        fn $test() {
            KINDS.iter().for_each(affinity::$test);
        }
    )*};
}

every_kind! {
    w_is_symmetric_with_entries_in_0_to_1_and_ones_on_the_diagonal
    a_used_stage_and_a_used_buffer_give_the_same_bits_as_new_ones
    few_returns_and_returns_in_one_place_have_defined_graphs
    w_is_blind_to_what_the_kind_states
}
