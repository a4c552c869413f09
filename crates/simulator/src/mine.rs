//! A mine: tunnels, rock and centrelines.

use crate::network::Network;
use crate::skeleton::Skeleton;
use crate::surface::Surface;

/// The tunnels of a mine, the rock around them, and their centrelines.
#[derive(Clone, Debug)]
pub struct Mine {
    network: Network,
    surface: Surface,
    skeleton: Skeleton,
}

impl Mine {
    /// The mine of a network with a surface made for it.
    pub fn new(network: Network, surface: Surface) -> Self {
        let skeleton = Skeleton::new(&network, &surface);
        Self { network, surface, skeleton }
    }

    /// The tunnels.
    pub fn network(&self) -> &Network {
        &self.network
    }

    /// The surface of the rock.
    pub fn surface(&self) -> &Surface {
        &self.surface
    }

    pub(crate) fn skeleton(&self) -> &Skeleton {
        &self.skeleton
    }
}
