//! The shared basis tables of this process; each is computed once.
//!
//! A table depends only on its key, so results do not depend on the content of the cache.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

use super::basis::BasisTable;
use super::folding::Folding;
use super::rule::Rule;

/// Maximum number of stored values (8 bytes each). The cache is emptied when a table would exceed
/// it. Tables in use stay alive.
const CAPACITY: usize = 2 << 20;

struct Cache {
    by_valences: BTreeMap<(Rule, [usize; 3]), Arc<BasisTable>>,
    folded: BTreeMap<(Rule, Folding), Arc<BasisTable>>,
    size: usize,
}

static CACHE: Mutex<Cache> = Mutex::new(Cache {
    by_valences: BTreeMap::new(),
    folded: BTreeMap::new(),
    size: 0,
});

/// The table of a triangle by its corner valences (each at least 3).
///
/// # Panics
/// If a valence is less than 3.
pub(super) fn table(valences: [usize; 3], rule: Rule) -> Arc<BasisTable> {
    cached(
        |cache| &mut cache.by_valences,
        (rule, valences),
        || BasisTable::new(valences, rule),
    )
}

/// The table of a triangle over its distinct real control vertices.
pub(super) fn folded_table(folding: &Folding, rule: Rule) -> Arc<BasisTable> {
    cached(
        |cache| &mut cache.folded,
        (rule, folding.clone()),
        || {
            if folding.is_flat() {
                BasisTable::flat(rule.points())
            } else {
                folding.apply(&table(folding.valences, rule))
            }
        },
    )
}

/// The table of `key`. If it is not in the cache, it is computed without holding the lock. Two
/// threads that miss the same key both compute it, and the first to finish stores it.
fn cached<K: Ord>(
    tables: impl Fn(&mut Cache) -> &mut BTreeMap<K, Arc<BasisTable>>,
    key: K,
    make: impl FnOnce() -> BasisTable,
) -> Arc<BasisTable> {
    let lock = || CACHE.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(table) = tables(&mut lock()).get(&key) {
        return Arc::clone(table);
    }
    let made = Arc::new(make());
    let mut cache = lock();
    if let Some(table) = tables(&mut cache).get(&key) {
        return Arc::clone(table);
    }
    if cache.size + made.data.len() > CAPACITY {
        cache.by_valences.clear();
        cache.folded.clear();
        cache.size = 0;
    }
    cache.size += made.data.len();
    tables(&mut cache).insert(key, Arc::clone(&made));
    made
}
