//! Linear parameter-varying control: LFTs, synthesis by linear matrix inequalities, analysis
